#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "planish/measure/figures.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/pipeline/verify_cage.h"
#include "planish/solve/backend.h"
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
  int changed = 0;
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
      EXPECT_LE(fitted.fit.within->left->bending, fitted.fit.within->exact->bending) << name;
      if (!fitted.fit.points.empty()) {
        EXPECT_GT(fitted.fit.within->distance.max, 1e-6) << name;
        ++changed;
      }

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
  EXPECT_GE(changed, 4);
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

struct Bent {
  double bending, folded, deeper_folded;
};

Bent bent(const FittedMesh& fitted) {
  const auto surface = fitted_surface(fitted.mesh, fitted.fit, fitted.evaluate_options());
  const SurfaceQuality one = surface_quality(*surface->level(1), fitted.mesh, {}, {});
  const SurfaceQuality two = surface_quality(*surface->level(2), fitted.mesh, {}, {});
  return {one.bending, one.folded_area, two.folded_area};
}

// As a report measures it: what may leave its vertices bends and folds no more for it, whatever the
// method and the mesh.
TEST(Within, NothingBendsMoreForIt) {
  const auto backend = make_cpu_backend();
  std::vector<test::NamedMesh> meshes = {{"sphere", noisy_sphere(0.001)},
                                         {"torus", test::torus(24, 12, 2, 0.7)},
                                         {"ball", test::jittered(test::icosphere(2), 0.3, 4)},
                                         {"prism", test::prism(9)}};
  for (std::uint32_t seed = 1; seed <= 3; ++seed) {
    meshes.push_back({"closed", test::random_closed_mesh(seed)});
    meshes.push_back({"dual", test::random_dual(40, seed)});
    meshes.push_back({"open", test::random_open_mesh(seed)});
    meshes.push_back(
        {"creased", test::with_random_creases(test::random_closed_mesh(seed + 5), 0.1, seed)});
  }
  int changed = 0, left = 0;
  for (const auto& [name, mesh] : meshes) {
    for (const std::optional<InterpolationMethod> method :
         {std::optional(InterpolationMethod::Progressive), std::optional(InterpolationMethod::Fair),
          std::optional<InterpolationMethod>()}) {
      MeshFitOptions options;
      options.method = method;
      options.refine = RefineChoice::Off;  // as it is where vertices may move
      const FittedMesh exact = fit_mesh(mesh, name, *backend, options);
      const Bent without = bent(exact);
      for (const double within : {1e-5, 1e-3, 1e-2}) {
        SCOPED_TRACE(name + " " + std::to_string(within));
        options.fit.within = within;
        const FittedMesh fitted = fit_mesh(mesh, name, *backend, options);
        const Bent with = bent(fitted);
        EXPECT_EQ(fitted.options.method, exact.options.method);
        EXPECT_LE(with.bending, without.bending * (1 + 1e-9));
        EXPECT_LE(with.folded, without.folded + 1e-12);
        EXPECT_LE(with.deeper_folded, without.deeper_folded + 1e-12);
        ASSERT_TRUE(fitted.fit.within && fitted.fit.within->left);
        EXPECT_NEAR(fitted.fit.within->left->bending, with.bending, 1e-9 * with.bending);
        EXPECT_LE(fitted.fit.within->distance.max, within);
        EXPECT_EQ(fitted.fit.points.empty(), fitted.fit.within->distance.max == 0);
        ++(fitted.fit.points.empty() ? left : changed);
      }
    }
  }
  EXPECT_GT(changed, left);
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
