#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "planish/backend/cpu_backend.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/pipeline/verify_cage.h"
#include "planish/surface/block_quality.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish {
namespace {

// Normals off by, at level 2 against those of the true sphere.
double normal_error(const FittedMesh& fitted, Backend& backend) {
  const SurfaceMesh surface =
      evaluate(fitted.mesh, fitted.fit, backend, fitted.evaluate_options(2));
  double sum = 0;
  for (std::size_t v = 0; v < surface.positions.size(); ++v) {
    const double cosine =
        glm::dot(glm::dvec3(surface.normals[v]), glm::normalize(surface.positions[v]));
    sum += std::pow(std::acos(std::min(cosine, 1.0)), 2);
  }
  return std::sqrt(sum / static_cast<double>(surface.positions.size()));
}

PolygonMesh noisy_sphere(double noise) {
  PolygonMesh mesh = test::icosphere(4);
  std::mt19937 random(9);
  std::normal_distribution<double> normal(0, noise * std::sqrt(12.0));
  for (glm::dvec3& p : mesh.positions) p *= 1 + normal(random);
  return mesh;
}

// By the limit points of the cage, against the given vertices.
TEST(Within, EveryVertexIsPassedWithinIt) {
  const auto backend = make_cpu_backend();
  const std::vector<test::NamedMesh> meshes = {
      {"sphere", noisy_sphere(0.002)},
      {"closed", test::random_closed_mesh(3)},
      {"open", test::random_open_mesh(4)},
      {"creased", test::with_random_creases(test::random_open_mesh(5), 0.2, 5)}};
  constexpr double kWithin = 0.004;
  for (const auto& [name, mesh] : meshes) {
    for (const InterpolationMethod method :
         {InterpolationMethod::Progressive, InterpolationMethod::Fair}) {
      MeshFitOptions options;
      options.method = method;
      options.fit.within = kWithin;
      const FittedMesh fitted = fit_mesh(mesh, name, *backend, options);
      EXPECT_TRUE(fitted.fit.interpolation.converged) << name;
      ASSERT_TRUE(fitted.fit.within) << name;
      EXPECT_FALSE(fitted.fit.within->noise);
      EXPECT_LT(fitted.fit.within->bending_after, 0.99 * fitted.fit.within->bending_before);
      EXPECT_GT(fitted.fit.within->at_bound, 0) << name;

      VerifyOptions how;
      how.method = method;
      how.tolerance = kWithin;
      const PolygonMesh cage = control_cage(fitted.mesh, fitted.fit, fitted.options.sharp);
      const Verification found = verify_cage(cage, mesh, how);
      EXPECT_TRUE(found.confirmed) << name << " " << found.error.max;
      EXPECT_NEAR(found.error.max, fitted.fit.within->distance.max, 2e-6) << name;
      EXPECT_NEAR(found.error.rms, fitted.fit.within->distance.rms, 2e-6) << name;
    }
  }
}

TEST(Within, MeasuredNoiseMakesNormalsBetter) {
  const auto backend = make_cpu_backend();
  constexpr double kNoise = 0.001;
  MeshFitOptions options;
  const double exact = normal_error(fit_mesh(noisy_sphere(kNoise), "sphere", *backend), *backend);
  options.fit.within.reset();
  const FittedMesh fitted = fit_mesh(noisy_sphere(kNoise), "sphere", *backend, options);
  ASSERT_TRUE(fitted.fit.within && fitted.fit.within->noise);
  EXPECT_NEAR(*fitted.fit.within->noise, kNoise, 0.12 * kNoise);
  EXPECT_DOUBLE_EQ(fitted.fit.within->within, kNoiseBound * *fitted.fit.within->noise);
  EXPECT_LT(normal_error(fitted, *backend), 0.5 * exact);
}

// What is not above the tolerance allows nothing.
TEST(Within, TheToleranceComesFirst) {
  const auto backend = make_cpu_backend();
  MeshFitOptions options;
  options.fit.within = 1e-6;
  const FittedMesh fitted = fit_mesh(noisy_sphere(0.001), "sphere", *backend, options);
  EXPECT_TRUE(fitted.fit.points.empty());
  EXPECT_EQ(fitted.fit.within->at_bound, 0);
}

}  // namespace
}  // namespace planish
