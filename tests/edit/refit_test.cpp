#include <gtest/gtest.h>

#include "edit/edit_case.h"
#include "planish/pipeline/fit_mesh.h"

namespace planish::test {
namespace {

std::vector<NamedMesh> edited_meshes() {
  return {{"sphere", jittered(icosphere(2), 0.3, 4)},
          {"closed", random_closed_mesh(5)},
          {"quads", torus(16, 10, 1, 0.4)},
          {"creased", with_random_creases(random_closed_mesh(2), 0.1, 3)},
          {"open", random_open_mesh(4)},
          {"dual", random_dual(60, 3)},
          {"drum", prism(24)}};
}

// Of the same method, of the mesh as it is now and nothing else.
SurfaceMesh fit_of(const Editor& editor, InterpolationMethod method) {
  MeshFitOptions options;
  options.method = method;
  options.repairs = false;
  options.quads = QuadChoice::Off;
  const auto backend = make_cpu_backend();
  const FittedMesh fitted = fit_mesh(editor.mesh(), "mesh", *backend, options);
  return evaluate(fitted.mesh, fitted.fit, *backend, fitted.evaluate_options(2));
}

class Refit : public testing::TestWithParam<InterpolationMethod> {};

// After a session of moves that the fit's decisions do not suit any more.
TEST_P(Refit, IsTheFitOfTheMeshAsItIs) {
  const bool is_fair = GetParam() == InterpolationMethod::Fair;
  double farthest_kept = 0;
  for (const auto& [name, given] : edited_meshes()) {
    SCOPED_TRACE(name);
    const auto backend = make_cpu_backend();
    EditorOptions options;
    options.fit.method = GetParam();
    const Fit first = fit(given, *backend, options.fit);
    ASSERT_TRUE(first.interpolation.converged);
    Editor editor(given, first, options);
    std::mt19937 random(2);
    std::uniform_int_distribution<std::int32_t> any(0, given.vertex_count() - 1);
    std::normal_distribution<double> normal(0, 0.004 * first.placement.diagonal);
    for (int i = 0; i < 250; ++i) {
      const std::int32_t vertex = any(random);
      const double x = normal(random), y = normal(random);
      const glm::dvec3 to = editor.points()[vertex] + glm::dvec3(x, y, normal(random));
      editor.move(std::span(&vertex, 1), std::span(&to, 1));
    }
    const double diagonal = first.placement.diagonal;
    const SurfaceMesh anew = fit_of(editor, GetParam());
    editor.settle();
    farthest_kept =
        std::max(farthest_kept, farthest(editor.positions(), anew.positions) / diagonal);

    const std::vector<glm::dvec3> points(editor.points().begin(), editor.points().end());
    const EditChange change = editor.refit();
    EXPECT_TRUE(change.is_whole);
    EXPECT_EQ(change.row_count, std::ssize(anew.positions));
    EXPECT_LT(farthest(editor.positions(), anew.positions), (is_fair ? 1e-9 : 2e-6) * diagonal);
    EXPECT_EQ(farthest(editor.points(), points), 0);
    EXPECT_EQ(farthest(editor.rest_positions(), points), 0);

    // The session goes on.
    ASSERT_TRUE(editor.can_undo());
    for (int i = 0; i < 20; ++i) editor.undo();
    EXPECT_LT(editor.measured_error(), 1.01e-6);
    for (int i = 0; i < 20; ++i) editor.redo();
    EXPECT_EQ(farthest(editor.points(), points), 0);
    editor.settle();
    EXPECT_LT(farthest(editor.positions(), anew.positions), (is_fair ? 1e-9 : 2e-6) * diagonal);
  }
  // Else this would test nothing.
  if (is_fair) {
    EXPECT_GT(farthest_kept, 1e-3);
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, Refit,
                         testing::Values(InterpolationMethod::Progressive,
                                         InterpolationMethod::Fair));

TEST(Refit, ThatIsCancelledChangesNothing) {
  EditCase c(icosphere(2));
  Editor editor(c.mesh, c.first, c.options);
  const std::vector<glm::dvec3> rows(editor.positions().begin(), editor.positions().end());
  Callbacks stop;
  stop.cancelled = [] { return true; };
  EXPECT_THROW(editor.refit(stop), Error);
  EXPECT_EQ(farthest(editor.positions(), rows), 0);
}

}  // namespace
}  // namespace planish::test
