#include "planish/limit/adaptive_tessellation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <oneapi/tbb/global_control.h>
#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>

#include "limit/tessellation_error.h"
#include "planish/files/mesh_file.h"
#include "support/expect_error.h"

namespace planish::test {
namespace {

using ::testing::HasSubstr;

AdaptiveSurface tessellated(const LimitCase& c, double chord_error, double angle = 0) {
  return tessellate(c.limit, {.chord_error = chord_error,
                              .angle = angle,
                              .diagonal = c.surface->placement().diagonal});
}

// Small meshes of every kind, also with few and many edges at a vertex.
std::vector<NamedMesh> adaptive_meshes() {
  std::vector<NamedMesh> meshes = limit_meshes();
  for (int n = 3; n <= 20; ++n) {
    meshes.push_back({"bipyramid " + std::to_string(n), bipyramid(n)});
    meshes.push_back({"prism " + std::to_string(n), prism(n)});
  }
  PolygonMesh holes = torus(8, 6, 2, 1);
  holes.hole_faces = {0, 1, 7, 20};
  meshes.push_back({"torus with holes", holes});
  return meshes;
}

TEST(AdaptiveTessellation, IsAsNearAsAskedForAndWatertight) {
  for (const auto& [name, mesh] : adaptive_meshes()) {
    const LimitCase c(mesh);
    const SurfaceQueries queries(c.limit);
    const Joints level_one = joints_of(c.tessellated(1));
    for (const double error : {1e-2, 1e-3}) {
      SCOPED_TRACE(name + ", " + std::to_string(error));
      const AdaptiveSurface surface = tessellated(c, error);
      const Joints joints = joints_of(surface.mesh);
      EXPECT_EQ(joints.bad_edges, level_one.bad_edges);
      EXPECT_EQ(joints.bad_triangles, level_one.bad_triangles);
      EXPECT_EQ(joints.euler(), level_one.euler());
      EXPECT_EQ(joints.boundary_edges > 0, level_one.boundary_edges > 0);
      const TessellationError found = tessellation_error(c, queries, surface.mesh, 2000);
      EXPECT_LE(found.to_surface, error);
      EXPECT_LE(found.to_triangles, error);
    }
  }
}

}  // namespace
}  // namespace planish::test
