#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <limits>
#include <vector>

#include "planish/mesh/check.h"
#include "planish/mesh/edge_groups.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/mesh/statistics.h"
#include "planish/reconstruct/reconstruct.h"
#include "planish/reconstruct/reconstruct_steps.h"
#include "reconstruct/test_clouds.h"
#include "support/calls.h"

namespace planish {
namespace {

using testing::IsEmpty;

const auto kNoEdges = [](std::int32_t, std::int32_t) { return false; };

TEST(FillHole, CutsAFoldedQuadAlongItsRidge) {
  // Two roof halves meet in the ridge from 0 to 2; the rim continues them outwards.
  const std::vector<glm::dvec3> positions = {{0, 0, 0.2}, {0.5, 1, 0}, {1, 0, 0.2}, {0.5, -1, 0}};
  const glm::dvec3 right = glm::normalize(glm::dvec3(0, 0.2, 1));
  const glm::dvec3 left = glm::normalize(glm::dvec3(0, -0.2, 1));
  const Hole hole{.loop = {0, 3, 2, 1}, .normals = {left, left, right, right}};
  const auto patch = fill_hole(positions, hole, kNoEdges);
  ASSERT_EQ(patch.size(), 2u);
  for (const Triangle& t : patch) {
    EXPECT_NE(std::ranges::find(t, 0), t.end());
    EXPECT_NE(std::ranges::find(t, 2), t.end());
  }
  // That edge is taken: the other way.
  const auto other = fill_hole(positions, hole, [](std::int32_t a, std::int32_t b) {
    return std::min(a, b) == 0 && std::max(a, b) == 2;
  });
  ASSERT_EQ(other.size(), 2u);
  for (const Triangle& t : other) EXPECT_NE(std::ranges::find(t, 1), t.end());
}

TEST(FillHole, KeepsTheLoopsDirection) {
  const std::vector<glm::dvec3> positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const Hole hole{.loop = {2, 0, 1}, .normals = std::vector(3, glm::dvec3(0, 0, 1))};
  const auto patch = fill_hole(positions, hole, kNoEdges);
  ASSERT_EQ(patch.size(), 1u);
  EXPECT_EQ(patch[0], (Triangle{2, 0, 1}));
}

TEST(FillHole, GivesUpWhereNoPatchExists) {
  const std::vector<glm::dvec3> line = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  EXPECT_THAT(fill_hole(line, {{0, 1, 2}, std::vector(3, glm::dvec3(0, 0, 1))}, kNoEdges),
              IsEmpty());
  const std::vector<glm::dvec3> square = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  EXPECT_THAT(fill_hole(square, {{0, 1, 2, 3}, std::vector(4, glm::dvec3(0, 0, 1))},
                        [](std::int32_t, std::int32_t) { return true; }),
              IsEmpty());
}

constexpr std::int32_t kSize = 40;

test::TriangleMesh wave() {
  return test::grid_mesh(kSize, [](double i, double) { return 4 * std::cos(0.15 * i); });
}

std::int32_t at(std::int32_t i, std::int32_t j) { return i * (kSize + 1) + j; }

// Over the rim's bay at j = 0, from one of its ends.
std::vector<Triangle> flap() {
  std::vector<Triangle> triangles;
  for (std::int32_t i = 2; i < kSize - 1; ++i)
    triangles.push_back({at(1, 0), at(i + 1, 0), at(i, 0)});
  return triangles;
}

std::vector<std::uint8_t> bridges_of(const test::TriangleMesh& mesh) {
  return open_bridges(mesh.positions, mesh.triangles);
}

TEST(OpenBridges, AreFlapsOverABay) {
  test::TriangleMesh mesh = wave();
  const std::size_t sheet = mesh.triangles.size();
  EXPECT_EQ(std::ranges::count(bridges_of(mesh), 1), 0);
  for (const Triangle& t : flap()) mesh.triangles.push_back(t);
  const std::vector<std::uint8_t> bridges = bridges_of(mesh);
  EXPECT_EQ(std::ranges::count(bridges, 1),
            std::ranges::count(bridges.begin() + sheet, bridges.end(), 1));
  // The first ones are no longer than the sheet's own.
  EXPECT_EQ(std::ranges::count(bridges.begin() + sheet + 4, bridges.end(), 0), 0);
  const RepairedTriangles repaired =
      repair_triangles(mesh.positions, mesh.triangles, {.longest_filled_loop = 0});
  EXPECT_EQ(repaired.dropped_triangle_count, std::ranges::count(bridges, 1));
}

TEST(OpenBridges, AreStripsAcrossAHoleButNotWhatClosesIt) {
  test::TriangleMesh mesh = wave();
  std::vector<std::int32_t> loop;  // counter-clockwise about the hole from 10 to 30
  for (std::int32_t k = 10; k < 30; ++k) loop.push_back(at(k, 10));
  for (std::int32_t k = 10; k < 30; ++k) loop.push_back(at(30, k));
  for (std::int32_t k = 30; k > 10; --k) loop.push_back(at(k, 30));
  for (std::int32_t k = 30; k > 10; --k) loop.push_back(at(10, k));
  std::erase_if(mesh.triangles, [](const Triangle& t) {
    return std::ranges::all_of(t, [](std::int32_t v) {
      const std::int32_t i = v / (kSize + 1), j = v % (kSize + 1);
      return i >= 10 && i <= 30 && j >= 10 && j <= 30;
    });
  });
  const std::size_t rest = mesh.triangles.size(), count = loop.size();
  test::TriangleMesh closed = mesh, strip = mesh;
  const auto middle = static_cast<std::int32_t>(mesh.positions.size());
  closed.positions.emplace_back(20, 20, 4 * std::cos(3));
  for (std::size_t k = 0; k < count; ++k)
    closed.triangles.push_back({middle, loop[k], loop[(k + 1) % count]});
  EXPECT_EQ(std::ranges::count(bridges_of(closed), 1), 0);
  strip.triangles.push_back({loop[30], loop[70], loop[69]});
  strip.triangles.push_back({loop[30], loop[31], loop[69]});
  std::vector<std::uint8_t> bridges = bridges_of(strip);
  EXPECT_EQ(std::ranges::count(bridges, 1), 2);
  EXPECT_TRUE(bridges[rest] && bridges[rest + 1]);
}

// A strip of two triangles from the wave to rows of another, 20 away.
test::TriangleMesh joined(std::int32_t rows) {
  test::TriangleMesh mesh = wave(), other = wave();
  const auto first = static_cast<std::int32_t>(mesh.positions.size());
  std::erase_if(other.triangles, [&](const Triangle& t) {
    return std::ranges::any_of(t, [&](std::int32_t v) { return v % (kSize + 1) > rows; });
  });
  test::append(mesh, other, {0, 60, 0});
  mesh.triangles.push_back({at(10, kSize), at(11, kSize), first + at(10, 0)});
  mesh.triangles.push_back({at(11, kSize), first + at(11, 0), first + at(10, 0)});
  return mesh;
}

TEST(OpenBridges, AreWhatJoinsTwoSheetsButNotWhatHoldsAScrap) {
  EXPECT_EQ(std::ranges::count(bridges_of(joined(kSize)), 1), 2);
  test::TriangleMesh mesh = joined(0);
  const auto first = static_cast<std::int32_t>(mesh.positions.size()) / 2;
  for (const std::int32_t i : {9, 10, 11})
    mesh.triangles.push_back({first + at(i, 0), first + at(i + 1, 0), first + at(i, 1)});
  EXPECT_EQ(std::ranges::count(bridges_of(mesh), 1), 0);
  for (const Triangle& t : flap()) mesh.triangles.push_back(t);
  EXPECT_GT(std::ranges::count(bridges_of(mesh), 1), 30);
}

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
  const std::size_t count = mesh.positions.size();
  test::append(mesh, sheet(), {0, 0, 9});
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
  const PolygonMesh mesh = test::polygons_of(torus.positions, result.triangles);
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
  const PolygonMesh mesh = test::polygons_of(torus.positions, closed.triangles);
  EXPECT_TRUE(check(mesh).empty());
  EXPECT_EQ(statistics(mesh).boundary_loop_count, 0);
}

TEST(Repair, KeepsTheAskedComponents) {
  test::TriangleMesh mesh = test::torus_mesh(20, 12);
  const test::TriangleMesh two{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                               {{0, 2, 1}, {0, 1, 3}}};
  test::append(mesh, two, {5, 0, 0});
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
  test::append(mesh, test::torus_mesh(3, 3), {5, 0, 0});
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
    const auto problems = check(test::polygons_of(positions, result.triangles));
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
