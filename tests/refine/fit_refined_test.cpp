// The surface through given and added vertices: nearer to the shape, through every given vertex.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "planish/edit/editor.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/pipeline/verify_cage.h"
#include "planish/surface/evaluate.h"
#include "support/cut_quads.h"
#include "support/delaunay_sphere.h"
#include "support/expect_error.h"
#include "support/meshes.h"

namespace planish {
namespace {

FittedMesh fitted(const PolygonMesh& mesh, RefineChoice refine, MeshFitOptions options = {}) {
  options.refine = refine;
  return fit_mesh(mesh, "mesh", *make_cpu_backend(), options);
}

SurfaceMesh surface_of(const FittedMesh& fit, int level) {
  return evaluate(fit.mesh, fit.fit, *make_cpu_backend(), fit.evaluate_options(level));
}

// Of the unit sphere, rms over the vertices of a level, in degrees.
double normals_off(const FittedMesh& fit, int level) {
  const SurfaceMesh surface = surface_of(fit, level);
  double sum = 0;
  for (std::size_t i = 0; i < surface.positions.size(); ++i) {
    const double cosine =
        glm::dot(glm::normalize(surface.positions[i]), glm::dvec3(surface.normals[i]));
    sum += std::pow(std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / std::numbers::pi, 2);
  }
  return std::sqrt(sum / static_cast<double>(surface.positions.size()));
}

TEST(FitRefined, IsNearerToTheShapeAndPassesEveryGivenVertex) {
  const PolygonMesh mesh = test::delaunay_sphere(600, 1);
  const FittedMesh plain = fitted(mesh, RefineChoice::Off), made = fitted(mesh, RefineChoice::Auto);
  EXPECT_TRUE(plain.added_vertices.empty());
  ASSERT_FALSE(made.added_vertices.empty());
  EXPECT_LT(normals_off(made, 1), 0.25 * normals_off(plain, 2));
  const SurfaceMesh surface = surface_of(made, 1);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    EXPECT_LT(glm::distance(surface.positions[v], mesh.positions[v]), 1e-12);
  EXPECT_THAT(made.choice->faces_reason, testing::HasSubstr("--refine off"));
  EXPECT_LT(made.choice->best().bending,
            0.5 * made.choice->of(CandidateFaces::Given, InterpolationMethod::Fair)->bending);
  EXPECT_EQ(made.source_vertices[5], 5);
  EXPECT_EQ(made.source_vertices.back(), -1);
}

TEST(FitRefined, AddsNothingToQuadsAndTheirHalves) {
  for (const PolygonMesh& mesh :
       {test::torus(24, 12, 1, 0.4), test::cut_quads(test::torus(32, 16, 1, 0.4)),
        test::cut_quads(test::flat_grid(9, 9)), test::cube()})
    EXPECT_TRUE(fitted(mesh, RefineChoice::Auto).added_vertices.empty());
}

TEST(FitRefined, AddsWhereThatIsAskedFor) {
  MeshFitOptions options;
  options.method = InterpolationMethod::Fair;
  const FittedMesh made = fitted(test::icosphere(2), RefineChoice::On, options);
  EXPECT_FALSE(made.added_vertices.empty());
  EXPECT_EQ(made.options.method, InterpolationMethod::Fair);
  // Auto leaves a method that was named as it is.
  EXPECT_TRUE(
      fitted(test::delaunay_sphere(200, 2), RefineChoice::Auto, options).added_vertices.empty());
}

TEST(FitRefined, HasACageThatCanBeVerified) {
  const PolygonMesh mesh = test::delaunay_sphere(200, 5);
  MeshFitOptions options;
  options.method = InterpolationMethod::Fair;
  const FittedMesh made = fitted(mesh, RefineChoice::On, options);
  const PolygonMesh cage = control_cage(made.mesh, made.fit, made.options.sharp);
  VerifyOptions verify;
  verify.method = InterpolationMethod::Fair;
  verify.quads = QuadChoice::Off;
  verify.refine = RefineChoice::On;
  const Verification right = verify_cage(cage, mesh, verify);
  EXPECT_TRUE(right.confirmed);
  EXPECT_LT(right.error.max, 1e-12);
  verify.refine = RefineChoice::Off;
  (void)test::message_of(ErrorCode::UnusableMesh, [&] { (void)verify_cage(cage, mesh, verify); });
}

// Some of few points look as if they were halves of quads.
TEST(FitRefined, IsTakenBeforeQuadsThatBendMore) {
  int both = 0, worse = 0;
  for (int seed = 1; seed <= 40; ++seed) {
    const PolygonMesh mesh = test::delaunay_sphere(20 + 2 * seed, static_cast<unsigned>(seed));
    MeshFitOptions round;
    round.chooses_creases = false;
    const FittedMesh made = fitted(mesh, RefineChoice::Auto, round);
    if (!made.choice->of(CandidateFaces::Quads, InterpolationMethod::Fair)) continue;
    SCOPED_TRACE(seed);
    ++both;
    if (made.added_vertices.empty()) continue;
    const FittedMesh plain = fitted(mesh, RefineChoice::Off, round);
    EXPECT_EQ(made.paired_count, 0);
    EXPECT_EQ(made.choice->best().faces, CandidateFaces::Refined);
    worse += normals_off(made, 1) >= normals_off(plain, 2);
  }
  EXPECT_GT(both, 0);
  EXPECT_LE(worse, 1) << "what bends least is not always nearest through so few points";
}

TEST(FitRefined, IsWrittenALevelLess) {
  const FittedMesh made = fitted(test::delaunay_sphere(200, 5), RefineChoice::Auto);
  EXPECT_EQ(made.density.level(), 1);
  EXPECT_EQ(fitted(test::delaunay_sphere(200, 5), RefineChoice::Off).density.level(), 2);
}

TEST(FitRefined, IsNotLeftBehindWithinABound) {
  MeshFitOptions options;
  options.fit.within = 1e-3;
  const FittedMesh made = fitted(test::delaunay_sphere(200, 5), RefineChoice::Auto, options);
  EXPECT_TRUE(made.added_vertices.empty());
}

TEST(FitRefined, HasWarningsOfTheSurfaceThatIsTakenAlone) {
  const PolygonMesh mesh = test::delaunay_sphere(200, 5);
  std::vector<Warning> told;
  MeshFitOptions options;
  options.fit.callbacks.warning = [&](const Warning& warning) { told.push_back(warning); };
  const FittedMesh made = fitted(mesh, RefineChoice::Auto, options);
  ASSERT_EQ(told.size(), made.warnings.size());
  for (std::size_t i = 0; i < told.size(); ++i)
    EXPECT_EQ(told[i].message, made.warnings[i].message);
}

// Each added vertex by the weights of the given ones that move, and by nothing else.
TEST(FitRefined, IsEditedByItsGivenVertices) {
  const FittedMesh made = fitted(test::delaunay_sphere(200, 5), RefineChoice::Auto);
  ASSERT_FALSE(made.added_vertices.empty());
  const auto given =
      static_cast<std::int32_t>(made.mesh.positions.size() - made.added_vertices.size());
  Editor editor(made);
  const std::vector<glm::dvec3> before(editor.points().begin(), editor.points().end());
  const std::array<std::int32_t, 2> vertices{7, 11};
  const glm::dvec3 way(0.02, -0.01, 0.03);
  editor.move(vertices, std::array{before[7] + way, before[11] - way});
  const auto way_of = [&](std::int32_t v) { return v == 7 ? way : v == 11 ? -way : glm::dvec3(0); };
  int followed = 0;
  for (std::int32_t v = 0; v < std::ssize(before); ++v) {
    glm::dvec3 expected(0);
    if (v < given) {
      expected = way_of(v);
    } else {
      const AddedVertex& added = made.added_vertices[v - given];
      for (int k = 0; k < 3; ++k) expected += added.weights[k] * way_of(added.vertices[k]);
      followed += expected != glm::dvec3(0);
    }
    EXPECT_LT(glm::distance(editor.points()[v] - before[v], expected), 1e-15);
  }
  EXPECT_GT(followed, 4);
  EXPECT_LT(editor.measured_error(), 1e-12);
  editor.undo();
  EXPECT_TRUE(std::ranges::equal(editor.points(), before));
  // They go on to follow where all is made anew.
  editor.refit();
  editor.move(std::array{7}, std::array{before[7] + way});
  EXPECT_GT(glm::distance(editor.points()[7], before[7]), 0.03);
  EXPECT_TRUE(std::any_of(before.begin() + given, before.end(), [&](const glm::dvec3& p) {
    return editor.points()[&p - before.data()] != p;
  }));
}

TEST(FitRefined, LetsNobodyMoveOrSelectAnAddedVertex) {
  const FittedMesh made = fitted(test::delaunay_sphere(200, 5), RefineChoice::Auto);
  const auto given =
      static_cast<std::int32_t>(made.mesh.positions.size() - made.added_vertices.size());
  Editor editor(made);
  EXPECT_THAT(test::message_of(ErrorCode::InvalidArgument,
                               [&] { editor.move(std::array{given}, std::array{glm::dvec3(0)}); }),
              testing::HasSubstr("the mesh has 0 to 199"));
  const Selection selection = editor.select(std::array{7}, 0.5);
  EXPECT_GT(selection.vertices.size(), 3u);
  EXPECT_TRUE(std::ranges::all_of(selection.vertices, [&](std::int32_t v) { return v < given; }));
  EXPECT_EQ(selection.weights.size(), selection.vertices.size());
  editor.transform(selection, glm::dmat4(1.01));
  EXPECT_LT(editor.measured_error(), 1e-12);
}

}  // namespace
}  // namespace planish
