// The project's own scenes: first level against the oracle, and the fitted surface through the
// given vertices.

#include <gtest/gtest.h>

#include <filesystem>
#include <glm/geometric.hpp>
#include <vector>

#include "conformance/catalogue.h"
#include "conformance/level_match.h"
#include "planish/files/mesh_file.h"
#include "planish/pipeline/fit.h"
#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"

namespace planish::test {
namespace {

using glm::dvec3;

std::vector<NamedMesh> scene_files() {
  std::vector<NamedMesh> meshes;
  for (const auto& entry : std::filesystem::directory_iterator(PLANISH_SCENES)) {
    if (entry.path().extension() != ".obj") continue;
    const std::string name = entry.path().filename().string();
    meshes.push_back({name, read_mesh(entry.path()).mesh});
    // Faces that are left out change nothing about the others, and the oracle knows none.
    meshes.back().mesh.hole_faces.clear();
  }
  return meshes;
}

TEST(SceneFiles, FirstLevelAgreesWithTheOracle) {
  const auto backend = make_cpu_backend();
  const std::vector<NamedMesh> meshes = scene_files();
  ASSERT_GE(meshes.size(), 10u);
  for (const auto& [name, mesh] : meshes) {
    if (mesh.vertex_count() > 5000) continue;  // the oracle is slow
    for (Weights weights : kBothWeights) {
      SCOPED_TRACE(name);
      const QuadSplitOracle oracle(mesh, weights, BoundaryRule::Edge);
      LevelMatch match;
      match.advance(evaluate(mesh, *backend, {.level = 1, .weights = weights}), oracle);
      const double diagonal = placement_of(mesh).diagonal;
      EXPECT_LT(match.worst_position(), 1e-12 * diagonal);
      EXPECT_LT(match.worst_normal(), 1e-6);
    }
  }
}

TEST(SceneFiles, FittedSurfacesPassThroughTheVertices) {
  const auto backend = make_cpu_backend();
  constexpr double kTolerance = 1e-8;
  for (const auto& [name, mesh] : scene_files()) {
    for (Weights weights : kBothWeights) {
      SCOPED_TRACE(name);
      const Fit result = fit(mesh, *backend, {.weights = weights, .tolerance = kTolerance});
      EXPECT_TRUE(result.interpolation.converged);
      const std::vector<dvec3> limits = limit_positions(result.cage, weights, {});
      double worst = 0;
      for (std::size_t v = 0; v < limits.size(); ++v) {
        worst = std::max(worst, glm::distance(limits[v], mesh.positions[v]));
      }
      EXPECT_LT(worst, 1.01 * kTolerance * result.placement.diagonal);
    }
  }
}

}  // namespace
}  // namespace planish::test
