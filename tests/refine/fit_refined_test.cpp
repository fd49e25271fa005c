// The surface through given and added vertices: nearer to the shape, through every given vertex.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
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
  EXPECT_THAT(made.refine_reason->text, testing::HasSubstr("--refine off"));
  EXPECT_LT(made.refine_reason->refined->bending, 0.5 * made.refine_reason->given->bending);
  EXPECT_EQ(made.source_vertices[5], 5);
  EXPECT_EQ(made.source_vertices.back(), -1);
}

TEST(FitRefined, AddsNothingWhereRingsAreEvenOrTrianglesAreHalvesOfQuads) {
  for (const PolygonMesh& mesh : {test::icosphere(3), test::cut_quads(test::torus(32, 16, 1, 0.4)),
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

TEST(FitRefined, CannotBeEdited) {
  const FittedMesh made = fitted(test::delaunay_sphere(200, 5), RefineChoice::Auto);
  ASSERT_FALSE(made.added_vertices.empty());
  (void)test::message_of(ErrorCode::InvalidArgument, [&] { const Editor editor(made); });
}

}  // namespace
}  // namespace planish
