#include "planish/reconstruct/simplify_state.h"

#include <gtest/gtest.h>

#include "planish/mesh/check.h"
#include "planish/mesh/statistics.h"
#include "reconstruct/test_clouds.h"

namespace planish {
namespace {

PolygonMesh polygons(const CollapseMesh& mesh, const std::vector<glm::dvec3>& positions) {
  std::vector<Triangle> triangles;
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t)
    if (mesh.is_alive(static_cast<std::int32_t>(t)))
      triangles.push_back(mesh.triangle(static_cast<std::int32_t>(t)));
  PolygonMesh result = polygons_of(triangles);
  result.positions = positions;
  return result;
}

// Valences that the mesh keeps up to date, against those counted afresh.
void expect_true_valences(const CollapseMesh& mesh, const PolygonMesh& polygons) {
  std::vector<std::int32_t> counted(polygons.positions.size(), 0);
  group_edges(polygons, std::vector<std::uint8_t>(polygons.face_count(), 1))
      .for_each([&](std::int32_t lower, std::span<const FaceSide> sides) {
        ++counted[lower];
        ++counted[sides.front().higher];
      });
  for (std::size_t v = 0; v < counted.size(); ++v) {
    const auto vertex = static_cast<std::int32_t>(v);
    ASSERT_EQ(mesh.is_used(vertex), counted[v] > 0);
    ASSERT_EQ(mesh.is_used(vertex) ? mesh.valence(vertex) : 0, counted[v]);
  }
}

// Random collapses and flips until little is left; all the time it is the same surface.
void expect_same_topology(const test::TriangleMesh& given, unsigned seed) {
  CollapseMesh mesh(given.triangles, given.positions.size());
  const MeshStatistics before = statistics(polygons(mesh, given.positions));
  std::mt19937 random(seed);
  Fan fan;
  for (int step = 0; step < 4000; ++step) {
    const auto vertex = static_cast<std::int32_t>(random() % given.positions.size());
    if (!mesh.is_used(vertex)) continue;
    mesh.get_fan(vertex, fan);
    const std::size_t target = random() % fan.ring.size();
    if (random() % 3 == 0) {
      const std::int32_t half_edge = fan.spokes[target % fan.spokes.size()];
      if (mesh.can_flip(half_edge)) mesh.flip(half_edge);
    } else if (mesh.can_collapse(vertex, fan, target)) {
      mesh.collapse(vertex, fan, target);
    }
    if (step % 100 != 0) continue;
    const PolygonMesh now = polygons(mesh, given.positions);
    const auto problems = check(now);
    ASSERT_TRUE(problems.empty()) << problems.front().message;
    const MeshStatistics after = statistics(now);
    ASSERT_EQ(after.genus, before.genus);
    ASSERT_EQ(after.component_count, before.component_count);
    ASSERT_EQ(after.boundary_loop_count, before.boundary_loop_count);
    expect_true_valences(mesh, now);
  }
  EXPECT_LT(statistics(polygons(mesh, given.positions)).face_count, before.face_count / 4);
}

TEST(CollapseMesh, KeepsTheTopologyOfAClosedMesh) {
  for (unsigned seed = 0; seed < 5; ++seed) expect_same_topology(test::torus_mesh(16, 10), seed);
}

TEST(CollapseMesh, KeepsTheTopologyOfAnOpenMesh) {
  test::TriangleMesh grid = test::grid_mesh(12, [](int i, int j) { return 0.1 * i * j; });
  grid.triangles.erase(grid.triangles.begin() + 100, grid.triangles.begin() + 104);
  for (unsigned seed = 0; seed < 5; ++seed) expect_same_topology(grid, seed);
}

TEST(CollapseMesh, GoesRoundAFanInOrder) {
  const test::TriangleMesh grid = test::grid_mesh(2, [](int, int) { return 0.0; });
  const CollapseMesh mesh(grid.triangles, grid.positions.size());
  Fan fan;
  mesh.get_fan(4, fan);
  EXPECT_TRUE(fan.closed);
  ASSERT_EQ(fan.ring.size(), 6u);
  ASSERT_EQ(fan.spokes.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) {
    const glm::dvec3 a = grid.positions[fan.ring[i]] - grid.positions[4];
    const glm::dvec3 b = grid.positions[fan.ring[(i + 1) % 6]] - grid.positions[4];
    EXPECT_GT(glm::cross(a, b).z, 0);
    EXPECT_EQ(mesh.end(fan.spokes[i]), fan.ring[i]);
  }
  mesh.get_fan(0, fan);
  EXPECT_FALSE(fan.closed);
  EXPECT_EQ(fan.ring, (std::vector<std::int32_t>{3, 4, 1}));
}

}  // namespace
}  // namespace planish
