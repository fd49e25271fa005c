#include "planish/reconstruct/reconstruct.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "planish/mesh/check.h"
#include "planish/mesh/edge_groups.h"
#include "planish/mesh/statistics.h"
#include "reconstruct/test_clouds.h"
#include "support/expect_error.h"

namespace planish {
namespace {

PolygonMesh repaired_polygons(const std::vector<glm::dvec3>& positions,
                              const std::vector<Triangle>& triangles) {
  PolygonMesh mesh = polygons_of(triangles);
  mesh.positions = positions;
  return mesh;
}

double volume(const std::vector<glm::dvec3>& p, const std::vector<Triangle>& triangles) {
  double sum = 0;
  for (const Triangle& t : triangles) sum += glm::dot(p[t[0]], glm::cross(p[t[1]], p[t[2]])) / 6;
  return sum;
}

TEST(Repair, OrientsTrianglesOfAnyWinding) {
  test::TriangleMesh torus = test::torus_mesh(20, 12);
  for (std::size_t t = 0; t < torus.triangles.size(); ++t)
    if (t % 3 != 1) std::swap(torus.triangles[t][0], torus.triangles[t][1]);
  const RepairedTriangles result = repair_triangles(torus.positions, torus.triangles);
  EXPECT_EQ(result.dropped_triangle_count, 0);
  const PolygonMesh mesh = repaired_polygons(torus.positions, result.triangles);
  EXPECT_TRUE(check(mesh).empty());
  EXPECT_EQ(statistics(mesh).genus, 1);
  EXPECT_GT(volume(torus.positions, result.triangles), 2);
}

// What has no volume has no outside.
TEST(Repair, FlatSheetsStayAsTheyAreWound) {
  test::TriangleMesh grid = test::grid_mesh(8, [](int, int) { return 0.0; });
  for (int side = 0; side < 2; ++side) {
    EXPECT_EQ(repair_triangles(grid.positions, grid.triangles).triangles, grid.triangles);
    for (Triangle& t : grid.triangles) std::swap(t[1], t[2]);
  }
}

TEST(Repair, FillsShortLoopsOnly) {
  test::TriangleMesh torus = test::torus_mesh(40, 24);
  // A hole of one vertex: six edges.
  std::erase_if(torus.triangles,
                [](const Triangle& t) { return std::ranges::find(t, 100) != t.end(); });
  const RepairedTriangles open =
      repair_triangles(torus.positions, torus.triangles, {.longest_filled_loop = 5});
  EXPECT_EQ(open.filled_loop_count, 0);
  const RepairedTriangles closed =
      repair_triangles(torus.positions, torus.triangles, {.longest_filled_loop = 6});
  EXPECT_EQ(closed.filled_loop_count, 1);
  EXPECT_EQ(closed.triangles.size(), torus.triangles.size() + 4);
  const PolygonMesh mesh = repaired_polygons(torus.positions, closed.triangles);
  EXPECT_TRUE(check(mesh).empty());
  EXPECT_EQ(statistics(mesh).boundary_loop_count, 0);
}

TEST(Repair, KeepsTheAskedComponents) {
  test::TriangleMesh mesh = test::torus_mesh(20, 12);
  const auto first = static_cast<std::int32_t>(mesh.positions.size());
  for (const glm::dvec3& p :
       {glm::dvec3(5, 0, 0), glm::dvec3(6, 0, 0), glm::dvec3(5, 1, 0), glm::dvec3(5, 0, 1)})
    mesh.positions.push_back(p);
  mesh.triangles.push_back({first, first + 2, first + 1});
  mesh.triangles.push_back({first, first + 1, first + 3});
  using Keep = ComponentRule::Keep;
  const auto left = [&](Keep keep, std::int64_t least) {
    return repair_triangles(mesh.positions, mesh.triangles, {.components = {keep, least}})
        .triangles.size();
  };
  EXPECT_EQ(left(Keep::Auto, 0), 480u);
  EXPECT_EQ(left(Keep::Largest, 0), 480u);
  EXPECT_EQ(left(Keep::All, 0), 482u);
  EXPECT_EQ(left(Keep::AtLeast, 2), 482u);
  EXPECT_EQ(left(Keep::AtLeast, 3), 480u);
}

TEST(Repair, KeepsPartsOfAFiftiethOfTheLargest) {
  test::TriangleMesh mesh = test::torus_mesh(20, 12);
  const test::TriangleMesh small = test::torus_mesh(3, 3);
  const auto first = static_cast<std::int32_t>(mesh.positions.size());
  for (const glm::dvec3& p : small.positions) mesh.positions.push_back(p + glm::dvec3(5, 0, 0));
  for (const Triangle& t : small.triangles)
    mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  for (const std::size_t kept : {10, 9, 8}) {
    mesh.triangles.resize(480 + kept);
    EXPECT_EQ(repair_triangles(mesh.positions, mesh.triangles, {.longest_filled_loop = 0})
                  .dropped_component_count,
              kept < 9);
  }
}

TEST(Repair, MakesAManifoldOfAnything) {
  std::mt19937 random(5);
  for (int round = 0; round < 300; ++round) {
    std::vector<glm::dvec3> positions;
    for (int i = 0; i < 9; ++i)
      positions.emplace_back(random() % 100, random() % 100, random() % 100);
    std::vector<Triangle> triangles;
    while (triangles.size() < 25) {
      const Triangle t = {static_cast<std::int32_t>(random() % 9),
                          static_cast<std::int32_t>(random() % 9),
                          static_cast<std::int32_t>(random() % 9)};
      if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) triangles.push_back(t);
    }
    const RepairedTriangles result =
        repair_triangles(positions, triangles, {.components = {ComponentRule::Keep::All}});
    const auto problems = check(repaired_polygons(positions, result.triangles));
    EXPECT_TRUE(problems.empty()) << problems.front().message;
    EXPECT_FALSE(result.triangles.empty());
  }
}

TEST(Repair, RefusesImpossibleLoops) {
  EXPECT_THAT(test::message_of(ErrorCode::InvalidArgument,
                               [] { (void)repair_triangles({}, {}, {.longest_filled_loop = -1}); }),
              testing::HasSubstr("0 to 1000"));
}

}  // namespace
}  // namespace planish
