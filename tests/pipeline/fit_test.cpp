#include "planish/pipeline/fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "planish/core/error.h"
#include "planish/patches/patch_mesh.h"
#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"
#include "support/expect_error.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish {
namespace {

// Largest distance of a vertex from the cage's limit surface, relative to the diagonal.
double interpolation_error(const PolygonMesh& given, const Fit& fit, const FitOptions& options) {
  const auto limits = limit_positions(fit.cage, options.weights, options.sharp);
  double largest = 0;
  for (std::size_t v = 0; v < limits.size(); ++v) {
    largest = std::max(largest, glm::length(limits[v] - given.positions[v]));
  }
  return largest / fit.placement.diagonal;
}

TEST(Fit, SurfacePassesThroughEveryVertex) {
  for (const PolygonMesh& mesh :
       {test::cube(), test::dodecahedron(), test::prism(9), test::plate_with_hole(5),
        test::l_shaped_plate(3), test::jittered(test::icosphere(2), 0.1, 4)}) {
    for (const Weights weights : {Weights::DooSabin, Weights::Averaged}) {
      FitOptions options;
      options.weights = weights;
      options.tolerance = 1e-12;
      const Fit result = fit(mesh, *make_cpu_backend(), options);
      EXPECT_TRUE(result.interpolation.converged);
      EXPECT_LT(interpolation_error(mesh, result, options), 1.01e-12);
      EXPECT_EQ(result.cage.face_vertices, mesh.face_vertices);
    }
  }
}

TEST(Fit, FarFromTheOriginInFloatReachesTheTolerance) {
  PolygonMesh mesh = test::icosphere(2);
  for (auto& p : mesh.positions) p += glm::dvec3(20.0, -20.0, 20.0);
  FitOptions options;
  options.tolerance = 2e-9;
  const Fit result = fit(mesh, *make_cpu_backend({Precision::Float}), options);
  EXPECT_TRUE(result.interpolation.converged);
  EXPECT_LT(interpolation_error(mesh, result, options), 2.1e-9);
}

TEST(Fit, LeavesUnusedVerticesWhereTheyAre) {
  PolygonMesh mesh = test::cube();
  mesh.positions.push_back({50, 60, 70});
  const Fit result = fit(mesh, *make_cpu_backend());
  EXPECT_EQ(result.cage.positions.back(), glm::dvec3(50, 60, 70));
  const Fit plain = fit(test::cube(), *make_cpu_backend());
  for (std::size_t v = 0; v < 8; ++v) EXPECT_EQ(result.cage.positions[v], plain.cage.positions[v]);
}

TEST(Fit, NamesTheWorstVertexOfTheGivenMesh) {
  PolygonMesh mesh = test::jittered(test::icosphere(1), 0.2, 5);
  mesh.positions.insert(mesh.positions.begin(), 3, glm::dvec3(0.0));
  for (std::int32_t& v : mesh.face_vertices) v += 3;
  FitOptions options;
  options.max_iterations = 3;
  options.tolerance = 1e-12;
  const Fit result = fit(mesh, *make_cpu_backend({Precision::Double}), options);
  const auto limits = limit_positions(result.cage, options.weights, options.sharp);
  std::vector<double> errors;
  for (std::size_t v = 0; v < limits.size(); ++v)
    errors.push_back(glm::length(limits[v] - mesh.positions[v]));
  const auto worst = std::ranges::max_element(errors);
  EXPECT_EQ(result.interpolation.worst_vertex, worst - errors.begin());
  EXPECT_NEAR(result.interpolation.error.max, *worst / result.placement.diagonal, 1e-12);
}

// Before anything is solved, and by the mesh's own numbers.
TEST(Fit, RefusesRingsWhoseSquareAveragedWeightsWouldTake) {
  FitOptions options;
  options.weights = Weights::Averaged;
  PolygonMesh hub = test::bipyramid(kLargestByPoints + 1);
  hub.positions.insert(hub.positions.begin(), 2, glm::dvec3(0.5));  // in no face
  for (std::int32_t& v : hub.face_vertices) v += 2;
  const auto said = [&](const PolygonMesh& mesh) {
    return test::message_of(ErrorCode::UnusableMesh,
                            [&] { (void)fit(mesh, *make_cpu_backend(), options); });
  };
  EXPECT_THAT(said(hub),
              testing::ContainsRegex("^vertex [0-9]+ has 1025 faces, averaged weights take 1024 "
                                     "at most; doo-sabin weights take more$"));
  EXPECT_EQ(said(test::prism(kLargestByPoints + 1)).substr(0, 24), "face 0 has 1025 corners,");
  // What is evaluated has as many: no cage gets round it.
  EXPECT_THROW((void)evaluate(hub, *make_cpu_backend(), {.weights = Weights::Averaged}), Error);
  const MeshTopology largest(test::bipyramid(kLargestByPoints));
  EXPECT_EQ(ring_columns(largest, Weights::Averaged), RingColumns::Points);
  options.weights = Weights::DooSabin;
  EXPECT_TRUE(fit(hub, *make_cpu_backend(), options).interpolation.converged);
}

TEST(Fit, ConjugateGradientsOnAnOpenMeshIsAUsageError) {
  FitOptions options;
  options.solver = Solver::ConjugateGradients;
  try {
    (void)fit(test::flat_grid(3, 3), *make_cpu_backend(), options);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
    EXPECT_NE(std::string(error.what()).find("12 boundary or crease edges"), std::string::npos)
        << error.what();
  }
}

TEST(Fit, WarnsOfSemiSharpCreases) {
  PolygonMesh mesh = test::cube();
  mesh.creases = {{0, 1, 2.5f}};
  std::vector<Warning> warnings;
  FitOptions options;
  options.callbacks.warning = [&](const Warning& w) { warnings.push_back(w); };
  (void)fit(mesh, *make_cpu_backend(), options);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].code, "semi-sharp-creases");
  EXPECT_NE(warnings[0].message.find("edge 0-1"), std::string::npos) << warnings[0].message;
}

TEST(Fit, ACubeWithAllEdgesTaggedIsItsOwnSurface) {
  PolygonMesh mesh = test::cube();
  for (const auto& [a, b] : {std::pair{0, 1},
                             {1, 3},
                             {3, 2},
                             {2, 0},
                             {4, 5},
                             {5, 7},
                             {7, 6},
                             {6, 4},
                             {0, 4},
                             {1, 5},
                             {2, 6},
                             {3, 7}}) {
    mesh.creases.push_back({a, b, kInfiniteSharpness});
  }
  const Fit result = fit(mesh, *make_cpu_backend());
  EXPECT_EQ(result.interpolation.iterations, 0);
  EXPECT_EQ(result.corner_count, 8);
  const SurfaceMesh surface = evaluate(result.cage, *make_cpu_backend(), {.level = 4});
  for (std::size_t v = 0; v < surface.positions.size(); ++v) {
    const glm::dvec3& p = surface.positions[v];
    EXPECT_NEAR(std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}), 1.0, 1e-12);
    // One of the planes through the point has this normal.
    const glm::dvec3 normal(surface.normals[v]);
    EXPECT_NEAR(glm::dot(normal, p), 1.0, 1e-6);
    EXPECT_NEAR(std::max({std::abs(normal.x), std::abs(normal.y), std::abs(normal.z)}), 1.0, 1e-6);
  }
}

}  // namespace
}  // namespace planish
