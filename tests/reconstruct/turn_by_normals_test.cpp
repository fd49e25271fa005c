#include "planish/reconstruct/reconstruct_steps.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <glm/geometric.hpp>
#include <limits>
#include <vector>

#include "planish/mesh/polygon_mesh.h"
#include "planish/reconstruct/reconstruct.h"
#include "reconstruct/test_clouds.h"

namespace planish {
namespace {

test::TriangleMesh sheet() {
  return test::grid_mesh(6, [](int i, int j) { return 0.05 * i * i - 0.1 * j; });
}

// z of the first triangle's normal.
double facing(std::span<const glm::dvec3> positions, const Triangle& t) {
  return glm::cross(positions[t[1]] - positions[t[0]], positions[t[2]] - positions[t[0]]).z;
}

TEST(TurnByNormals, OpenSheetsFollowTheMajority) {
  const test::TriangleMesh mesh = sheet();
  const double before = facing(mesh.positions, mesh.triangles.front());
  for (const float sign : {1.0f, -1.0f}) {
    // A fifth is wrong, some are silent.
    std::vector<glm::vec3> normals(mesh.positions.size(), {0, 0, sign * 3});
    for (std::size_t i = 0; i < normals.size(); i += 5) normals[i] = -normals[i];
    normals[1] = glm::vec3(0.0f);
    normals[2] = glm::vec3(std::numeric_limits<float>::quiet_NaN());
    std::vector<Triangle> triangles = mesh.triangles;
    const bool agrees = sign * before > 0;
    EXPECT_EQ(turn_by_normals(mesh.positions, normals, triangles), agrees ? 0 : 1);
    for (const Triangle& t : triangles) EXPECT_GT(sign * facing(mesh.positions, t), 0);
  }
}

TEST(TurnByNormals, SheetsTurnEachForItself) {
  test::TriangleMesh mesh = sheet();
  const std::size_t count = mesh.positions.size(), triangle_count = mesh.triangles.size();
  for (std::size_t i = 0; i < count; ++i)
    mesh.positions.push_back(mesh.positions[i] + glm::dvec3(0, 0, 9));
  for (std::size_t t = 0; t < triangle_count; ++t) {
    Triangle moved = mesh.triangles[t];
    for (std::int32_t& v : moved) v += static_cast<std::int32_t>(count);
    mesh.triangles.push_back(moved);
  }
  std::vector<glm::vec3> normals(2 * count, {0, 0, 1});
  for (std::size_t i = count; i < 2 * count; ++i) normals[i] = {0, 0, -1};
  EXPECT_EQ(turn_by_normals(mesh.positions, normals, mesh.triangles), 1);
  EXPECT_GT(facing(mesh.positions, mesh.triangles.front()), 0);
  EXPECT_LT(facing(mesh.positions, mesh.triangles.back()), 0);
}

TEST(TurnByNormals, ClosedOnesStay) {
  test::TriangleMesh mesh = test::torus_mesh(12, 8);
  std::vector<glm::vec3> inward;
  for (const glm::dvec3& p : mesh.positions) inward.emplace_back(glm::vec3(-p.x, -p.y, -p.z));
  const std::vector<Triangle> before = mesh.triangles;
  EXPECT_EQ(turn_by_normals(mesh.positions, inward, mesh.triangles), 0);
  EXPECT_EQ(mesh.triangles, before);
}

// The whole way: orientation and colours of a cloud arrive at the mesh.
TEST(TurnByNormals, CloudsGiveTheirMeshNormalsAndColours) {
  const test::TriangleMesh mesh = sheet();
  const Mesher mesher = [&](std::span<const glm::dvec3>, const Callbacks&) {
    return mesh.triangles;
  };
  for (const float sign : {1.0f, -1.0f}) {
    PointCloud cloud{.points = mesh.positions};
    cloud.normals.assign(mesh.positions.size(), {0, 0, sign});
    for (std::size_t i = 0; i < mesh.positions.size(); ++i)
      cloud.colors.emplace_back(0.01f * static_cast<float>(i), 0.5f, 0.25f, 1.0f);
    cloud.attributes.push_back(attribute_of_size("intensity", 2, mesh.positions.size()));
    for (std::size_t i = 0; i < cloud.attributes[0].values.size(); ++i)
      cloud.attributes[0].values[i] = static_cast<float>(i);
    const Reconstruction result = reconstruct(cloud, mesher, {.tolerance = 1e-3});
    ASSERT_EQ(result.mesh.colors.size(), result.mesh.positions.size());
    for (std::size_t v = 0; v < result.mesh.colors.size(); ++v)
      EXPECT_EQ(result.mesh.colors[v], cloud.colors[result.vertex_points[v]]);
    ASSERT_EQ(result.mesh.attributes.size(), 1u);
    ASSERT_EQ(result.mesh.attributes[0].count(), result.mesh.positions.size());
    for (std::size_t v = 0; v < result.mesh.positions.size(); ++v)
      EXPECT_EQ(result.mesh.attributes[0].values[2 * v + 1],
                2 * static_cast<float>(result.vertex_points[v]) + 1);
    for (std::int32_t f = 0; f < result.mesh.face_count(); ++f) {
      const auto face = result.mesh.face(f);
      EXPECT_GT(sign * facing(result.mesh.positions, {face[0], face[1], face[2]}), 0);
    }
  }
}

}  // namespace
}  // namespace planish
