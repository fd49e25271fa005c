// Surfaces made in a host's command buffers, against fit() and evaluate() on the CPU.
#include "planish/vulkan/embed.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <glm/geometric.hpp>
#include <limits>

#include "planish/backend/cpu_backend.h"
#include "planish/surface/evaluate.h"
#include "support/meshes.h"
#include "support/random_meshes.h"
#include "vulkan/embedding_fixture.h"

namespace planish::testing {
namespace {

using namespace vulkan;

// Single precision of coordinates of a few units, through a solve and a chain of levels.
constexpr double kDistance = 4e-6;
constexpr double kCosine = 1 - 1e-5;

/// Meshes whose vertices, faces, boundaries and creases differ most.
std::vector<test::NamedMesh> mixed_meshes() {
  PolygonMesh unused = test::torus(9, 6, 2, 0.7);
  unused.positions.insert(unused.positions.begin() + 20, glm::dvec3(100, 0, 0));
  for (std::int32_t& v : unused.face_vertices) v += v >= 20;
  PolygonMesh holed = test::torus(9, 6, 2, 0.7);
  holed.hole_faces = {3, 17};
  return {{"icosphere", test::icosphere(2)},
          {"torus", test::torus(12, 7, 2, 0.7)},
          {"random", test::random_closed_mesh(3)},
          {"open", test::random_open_mesh(4)},
          {"creases", test::with_random_creases(test::random_open_mesh(5), 0.15, 6)},
          {"unused vertex", unused},
          {"holes", holed}};
}

TEST_F(Embedding, SurfaceEqualsTheCpus) {
  for (const test::NamedMesh& mesh : mixed_meshes())
    for (const int level : {0, 1, 2}) {
      SystemOptions options;
      options.level = level;
      HostTopology topology(*context_, mesh.mesh, options);
      topology.upload(*submitter_);
      HostFrame frame(*context_, topology);
      SolveParameters parameters;
      parameters.iterations = 40;
      const PolygonMesh pose = posed(mesh.mesh, 1);
      const Difference off =
          difference(run(frame, pose, parameters), surface_by_cpu(pose, mesh.mesh, options));
      EXPECT_LT(off.distance, kDistance) << mesh.name << " " << level;
      EXPECT_GT(off.cosine, kCosine) << mesh.name << " " << level;
      EXPECT_EQ(frame.status().iterations, 40u);
      EXPECT_EQ(frame.status().state, SolveState::Stepped);
      EXPECT_LT(frame.status().residual, 2e-6) << mesh.name << " " << level;
    }
}

}  // namespace
}  // namespace planish::testing
