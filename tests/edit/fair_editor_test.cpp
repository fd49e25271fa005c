#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "edit/edit_case.h"

namespace planish::test {
namespace {

struct FairEditCase {
  FairEditCase(PolygonMesh given, std::int32_t polish_steps)
      : mesh(std::move(given)), backend(make_cpu_backend()) {
    options.fit.method = InterpolationMethod::Fair;
    options.fit.polish_steps = polish_steps;
    options.fit.keeps_planes = true;
    first = fit(mesh, *backend, options.fit);
  }
  // From scratch, with the decisions of the first pose.
  [[nodiscard]] SurfaceMesh from_scratch(const PolygonMesh& moved) const {
    FitOptions kept = options.fit;
    kept.fair_decisions = &first.fair->decisions;
    const Fit result = fit(moved, *backend, kept);
    EvaluateOptions evaluate;
    evaluate.rest_positions = mesh.positions;
    return planish::evaluate(moved, result, *backend, evaluate);
  }

  PolygonMesh mesh;
  std::unique_ptr<Backend> backend;
  EditorOptions options;
  Fit first;
};

std::vector<NamedMesh> fair_meshes() {
  return {{"torus", torus(80, 60, 1, 0.4)},
          {"sphere", jittered(icosphere(4), 0.3, 4)},
          {"creased", with_random_creases(jittered(icosphere(4), 0.2, 2), 0.05, 3)},
          {"open", with_random_creases(jittered(flat_grid(60, 60), 0.2, 5), 0.03, 6)},
          {"planes", rounded_box({1, 0.7, 0.4}, 0.3, 24)}};
}

PolygonMesh moved_at_random(Editor& editor, const FairEditCase& c, double part, int moves) {
  std::mt19937 random(11);
  std::uniform_int_distribution<std::int32_t> any(0, c.mesh.vertex_count() - 1);
  std::uniform_real_distribution<double> way(-part, part);
  for (int i = 0; i < moves; ++i) {
    const std::int32_t vertex = any(random);
    const glm::dvec3 to =
        editor.points()[vertex] +
        c.first.placement.diagonal * glm::dvec3(way(random), way(random), way(random));
    const EditChange change = editor.move(std::span(&vertex, 1), std::span(&to, 1));
    EXPECT_FALSE(change.is_whole);
  }
  return editor.mesh();
}

// Without the polish all is local: an edited net is the whole net.
TEST(FairEditor, IsTheWholeNetWithoutPolish) {
  for (const auto& [name, mesh] : fair_meshes()) {
    SCOPED_TRACE(name);
    const FairEditCase c(mesh, 0);
    Editor editor(c.mesh, c.first, c.options);
    const SurfaceMesh whole = c.from_scratch(moved_at_random(editor, c, 0.004, 4));
    EXPECT_LT(farthest(editor.positions(), whole.positions), 1e-12 * c.first.placement.diagonal);
  }
}

TEST(FairEditor, PassesThroughItsPointsAndStaysNearTheWholeNet) {
  for (const auto& [name, mesh] : fair_meshes()) {
    SCOPED_TRACE(name);
    const FairEditCase c(mesh, 8);
    Editor editor(c.mesh, c.first, c.options);
    const std::vector<glm::dvec3> rest(editor.positions().begin(), editor.positions().end());
    const double part = 0.004;
    const SurfaceMesh whole = c.from_scratch(moved_at_random(editor, c, part, 4));
    EXPECT_LT(editor.measured_error(), 1e-13);
    EXPECT_LE(editor.measured_error(), editor.error_bound() + 1e-15);
    // The polish is minimised on a part: off by a few hundredths of the moves.
    EXPECT_LT(farthest(editor.positions(), whole.positions),
              0.05 * part * c.first.placement.diagonal);
    // The polish is in single precision, and the whole fit takes a moved bounding box for its unit.
    const EditChange settled = editor.settle();
    EXPECT_TRUE(settled.is_whole);
    EXPECT_LT(farthest(editor.positions(), whole.positions), 1e-8 * c.first.placement.diagonal);
    while (editor.can_undo()) editor.undo();
    EXPECT_LT(editor.measured_error(), 1e-13);
    EXPECT_LT(farthest(editor.positions(), rest), 0.05 * part * c.first.placement.diagonal);
  }
}

// What parts leave does not add up for ever: the whole net is made once in so many moves.
TEST(FairEditor, MakesTheWholeNetOnceInAWhile) {
  FairEditCase c(torus(80, 60, 1, 0.4), 8);
  c.options.settle_after = 3;
  Editor editor(c.mesh, c.first, c.options);
  std::vector<bool> is_whole;
  for (int i = 0; i < 9; ++i) {
    const std::int32_t vertex = 500 * i + 7;
    const glm::dvec3 to = editor.points()[vertex] + glm::dvec3(0.01, 0.02, 0);
    is_whole.push_back(editor.move(std::span(&vertex, 1), std::span(&to, 1)).is_whole);
    if (!is_whole.back()) continue;
    EXPECT_LT(farthest(editor.positions(), c.from_scratch(editor.mesh()).positions),
              1e-8 * c.first.placement.diagonal);
  }
  EXPECT_THAT(is_whole,
              testing::ElementsAre(false, false, false, true, false, false, false, true, false));
  EXPECT_LT(editor.error_bound(), 1e-14);
}

}  // namespace
}  // namespace planish::test
