#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <random>
#include <set>

#include "planish/mesh/check.h"
#include "planish/mesh/edge_groups.h"
#include "planish/mesh/statistics.h"
#include "planish/reconstruct/reconstruct.h"
#include "planish/reconstruct/reconstruct_steps.h"
#include "planish/reconstruct/simplify_state.h"
#include "reconstruct/test_clouds.h"
#include "support/calls.h"

namespace planish::test {
namespace {

// The state of simplify() for a mesh that uses its first `vertex_count` positions; vertices keep
// their numbers, and further positions are carried.
struct GivenState {
  GivenState(const TriangleMesh& mesh, std::size_t vertex_count, const SimplifyOptions& given)
      : points(mesh.positions),
        options(given),
        state(points, in_order(mesh, vertex_count), options) {}

  WitnessedMesh in_order(const TriangleMesh& mesh, std::size_t vertex_count) const {
    WitnessedMesh result{.triangles = mesh.triangles};
    result.vertex_points.resize(vertex_count);
    std::vector<std::int32_t> loose;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto given = static_cast<std::size_t>(points.given(i));
      if (given < vertex_count)
        result.vertex_points[given] = static_cast<std::int32_t>(i);
      else
        loose.push_back(static_cast<std::int32_t>(i));
    }
    result.carriers.assign(points.size(), -1);
    const TriangleTree tree(mesh.positions, mesh.triangles);
    for (const std::int32_t point : loose)
      result.carriers[point] = tree.nearest(points[point]).triangle;
    return result;
  }

  OrderedPoints points;
  SimplifyOptions options;
  SimplifyState state;
};

}  // namespace
}  // namespace planish::test

namespace planish {
namespace {

std::vector<Triangle> triangles_of(const CollapseMesh& mesh) {
  std::vector<Triangle> triangles;
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t)
    if (mesh.is_alive(static_cast<std::int32_t>(t)))
      triangles.push_back(mesh.triangle(static_cast<std::int32_t>(t)));
  return triangles;
}

PolygonMesh polygons(const CollapseMesh& mesh, const std::vector<glm::dvec3>& positions) {
  return test::polygons_of(positions, triangles_of(mesh));
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

bool has_edge(const CollapseMesh& mesh, std::int32_t a, std::int32_t b) {
  bool found = false;
  mesh.for_each_neighbour(a, [&](std::int32_t n) { found = found || n == b; });
  return found;
}

// A roof whose ridge crosses the diagonals of the grid.
TEST(FlipPass, LaysEdgesAlongTheRidge) {
  constexpr std::int32_t kSize = 12;
  const test::TriangleMesh roof =
      test::grid_mesh(kSize, [](int i, int j) { return -0.8 * std::abs(i + j - kSize); });
  const SimplifyOptions options{.tolerance = 10, .least_angle = 3};
  test::GivenState given(roof, roof.positions.size(), options);
  SimplifyState& state = given.state;
  FlipPass(state).run();
  const auto at = [](std::int32_t i) { return i * (kSize + 1) + kSize - i; };
  // The last squares at the border would take an edge from a vertex that has none to give.
  for (std::int32_t i = 1; i + 2 < kSize; ++i) EXPECT_TRUE(has_edge(state.mesh, at(i), at(i + 1)));
  EXPECT_EQ(state.result.vertex_count, (kSize + 1) * (kSize + 1));
}

TEST(FlipPass, FlipsNothingThatMovesACarriedPointTooFar) {
  test::TriangleMesh flat = test::grid_mesh(2, [](int, int) { return 0.0; });
  // Long triangles, so that the other diagonal is far better; a point lies on the one there is.
  for (glm::dvec3& p : flat.positions) p.x += 0.8 * p.y;
  flat.positions[8].z = flat.positions[4].z = 0.2;
  flat.positions.push_back(0.5 * (flat.positions[4] + flat.positions[8]));
  for (const double tolerance : {1.0, 1e-3}) {
    const SimplifyOptions options{.tolerance = tolerance, .least_angle = 3};
    test::GivenState given(flat, 9, options);
    FlipPass(given.state).run();
    EXPECT_EQ(has_edge(given.state.mesh, 4, 8), tolerance < 0.01) << tolerance;
  }
}

// Mean distance of vertices from the middle of their neighbours, in lengths of their edges.
double unevenness(const CollapseMesh& mesh, const std::vector<glm::dvec3>& positions) {
  double sum = 0;
  int count = 0;
  for (std::int32_t v = 0; v < static_cast<std::int32_t>(positions.size()); ++v) {
    if (!mesh.is_used(v) || mesh.is_boundary(v)) continue;
    glm::dvec3 middle(0.0);
    double length = 0;
    mesh.for_each_neighbour(v, [&](std::int32_t n) {
      middle += positions[n] - positions[v];
      length += glm::distance(positions[n], positions[v]);
    });
    sum += glm::length(middle) / length;
    ++count;
  }
  return sum / count;
}

void expect_moved_within_tolerance(const test::TriangleMesh& given, double tolerance) {
  const SimplifyOptions options{.tolerance = tolerance};
  test::GivenState given_state(given, given.positions.size(), options);
  SimplifyState& state = given_state.state;
  CollapsePass(state).run();
  const MeshStatistics before = statistics(polygons(state.mesh, state.positions));
  const double uneven = unevenness(state.mesh, state.positions);
  MovePass(state).run();
  EXPECT_GT(state.result.move_count, 10);
  EXPECT_LT(unevenness(state.mesh, state.positions), 0.98 * uneven);
  const std::vector<Triangle> triangles = triangles_of(state.mesh);
  const PointDistances distances = measure_distances(given.positions, state.positions, triangles);
  EXPECT_LE(distances.max, tolerance * (1 + 1e-12));
  const PolygonMesh mesh = test::polygons_of(state.positions, triangles);
  for (std::size_t v = 0; v < state.positions.size(); ++v)
    EXPECT_EQ(state.positions[v], state.points[state.vertex_points[v]]);
  EXPECT_TRUE(check(mesh).empty());
  const MeshStatistics after = statistics(mesh);
  EXPECT_EQ(after.genus, before.genus);
  EXPECT_EQ(after.boundary_loop_count, before.boundary_loop_count);
  EXPECT_EQ(after.unused_vertex_count, before.unused_vertex_count);
  EXPECT_EQ(after.face_count, before.face_count);
}

TEST(MovePass, EvensOutAClosedMeshWithinTheTolerance) {
  expect_moved_within_tolerance(test::torus_mesh(80, 40), 0.01);
}

TEST(MovePass, EvensOutAnOpenMeshWithinTheTolerance) {
  expect_moved_within_tolerance(
      test::grid_mesh(40, [](int i, int j) { return 0.5 * std::sin(0.7 * i) * std::cos(0.5 * j); }),
      0.05);
}

TEST(MovePass, LeavesAMeshAloneThatCarriesNothing) {
  const test::TriangleMesh torus = test::torus_mesh(20, 10);
  const SimplifyOptions options{.tolerance = 1};
  test::GivenState given(torus, torus.positions.size(), options);
  SimplifyState& state = given.state;
  MovePass(state).run();
  EXPECT_EQ(state.result.move_count, 0);
  EXPECT_EQ(triangles_of(state.mesh), torus.triangles);
}

using testing::HasSubstr;

MeshStatistics checked_statistics(const std::vector<glm::dvec3>& positions,
                                  const std::vector<Triangle>& triangles) {
  const PolygonMesh mesh = test::polygons_of(positions, triangles);
  EXPECT_TRUE(check(mesh).empty());
  return statistics(mesh);
}

double least_angle(const std::vector<glm::dvec3>& p, const std::vector<Triangle>& triangles) {
  double least = 180;
  for (const Triangle& t : triangles)
    for (int i = 0; i < 3; ++i) {
      const glm::dvec3 a = p[t[(i + 1) % 3]] - p[t[i]], b = p[t[(i + 2) % 3]] - p[t[i]];
      least = std::min(least, std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)) * 180 /
                                  std::numbers::pi);
    }
  return least;
}

// Of vertices that triangles surround.
std::size_t least_inner_valence(const std::vector<Triangle>& triangles) {
  std::map<std::int32_t, std::set<std::int32_t>> neighbours;
  std::map<std::int32_t, std::size_t> around;
  for (const Triangle& t : triangles)
    for (const std::int32_t corner : t) {
      ++around[corner];
      neighbours[corner].insert(t.begin(), t.end());
    }
  std::size_t least = std::numeric_limits<std::size_t>::max();
  for (const auto& [vertex, found] : neighbours)
    if (found.size() - 1 == around[vertex]) least = std::min(least, around[vertex]);
  return least;
}

TEST(Simplify, KeepsEveryPointWithinTheTolerance) {
  const test::TriangleMesh torus = test::torus_mesh(80, 40);
  for (const Spacing spacing : {Spacing::Adaptive, Spacing::Even}) {
    for (const double tolerance : {0.05, 0.01, 0.002}) {
      const SimplifiedMesh result =
          simplify(torus.positions, torus.triangles, {.tolerance = tolerance, .spacing = spacing});
      EXPECT_LE(test::greatest_distance(torus.positions, result.triangles),
                tolerance * (1 + 1e-12));
      const MeshStatistics facts = checked_statistics(torus.positions, result.triangles);
      EXPECT_EQ(facts.genus, 1);
      EXPECT_EQ(facts.boundary_loop_count, 0);
      EXPECT_EQ(facts.vertex_count - facts.unused_vertex_count, result.vertex_count);
      EXPECT_EQ(result.vertex_count + result.collapse_count, 3200);
      EXPECT_GE(least_angle(torus.positions, result.triangles),
                default_least_angle(spacing) - 1e-9);
    }
  }
}

// Rough, uneven and open, so that every pass has to give way somewhere.
TEST(Simplify, KeepsEveryPointOfARoughMesh) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    std::mt19937 random(seed);
    const auto unit = [&] { return static_cast<double>(random()) / 4294967296.0; };
    test::TriangleMesh grid = test::grid_mesh(36, [&](int i, int j) {
      return 1.5 * std::sin(0.4 * i) * std::sin(0.3 * j) + 0.1 * unit();
    });
    for (glm::dvec3& p : grid.positions) p += glm::dvec3(0.6 * unit(), 0.6 * unit(), 0);
    grid.triangles.erase(grid.triangles.begin() + 900, grid.triangles.begin() + 904);
    const MeshStatistics before = checked_statistics(grid.positions, grid.triangles);
    for (const Spacing spacing : {Spacing::Adaptive, Spacing::Even}) {
      const SimplifiedMesh result =
          simplify(grid.positions, grid.triangles, {.tolerance = 0.12, .spacing = spacing});
      EXPECT_GT(result.collapse_count, 100);
      EXPECT_GT(result.flip_count, 20);
      EXPECT_GT(result.move_count, 5);
      EXPECT_LE(test::greatest_distance(grid.positions, result.triangles), 0.12 * (1 + 1e-12));
      EXPECT_GE(least_inner_valence(result.triangles), 4u);
      const MeshStatistics facts = checked_statistics(grid.positions, result.triangles);
      EXPECT_EQ(facts.genus, before.genus);
      EXPECT_EQ(facts.component_count, before.component_count);
      EXPECT_EQ(facts.boundary_loop_count, before.boundary_loop_count);
    }
  }
}

TEST(Simplify, GivesTheSameMeshForPointsInAnotherOrder) {
  const test::TriangleMesh torus = test::torus_mesh(40, 20);
  const auto count = static_cast<std::int32_t>(torus.positions.size());
  test::TriangleMesh turned = torus;
  std::ranges::reverse(turned.positions);
  std::ranges::reverse(turned.triangles);
  for (Triangle& t : turned.triangles)
    for (std::int32_t& corner : t) corner = count - 1 - corner;
  const auto places = [](const test::TriangleMesh& mesh) {
    std::vector<std::array<double, 9>> result;
    for (const Triangle& t :
         simplify(mesh.positions, mesh.triangles, {.tolerance = 0.02}).triangles) {
      std::array<double, 9> corners{};
      for (std::size_t i = 0; i < 9; ++i)
        corners[i] = mesh.positions[t[i / 3]][static_cast<int>(i % 3)];
      result.push_back(corners);
    }
    std::ranges::sort(result);
    return result;
  };
  EXPECT_EQ(places(torus), places(turned));
}

TEST(Simplify, LeavesLittleOfAPlane) {
  const test::TriangleMesh grid = test::grid_mesh(30, [](int, int) { return 0.0; });
  const SimplifiedMesh result = simplify(grid.positions, grid.triangles, {.tolerance = 1e-9});
  EXPECT_LT(result.vertex_count, 80);
  EXPECT_LE(test::greatest_distance(grid.positions, result.triangles), 1e-9);
  EXPECT_EQ(checked_statistics(grid.positions, result.triangles).boundary_loop_count, 1);
}

// All vertices are beyond the largest ratio of edges; each collapse makes some of them a hair
// worse.
TEST(Simplify, LeavesLittleOfLinesFarApart) {
  std::mt19937 random(3);
  test::TriangleMesh grid = test::grid_mesh(60, [](int, int) { return 0.0; });
  for (glm::dvec3& p : grid.positions) {
    p.x = 30 * p.x;
    p.y += 0.2 * static_cast<double>(random() % 1000) / 1000;
  }
  const SimplifiedMesh result = simplify(grid.positions, grid.triangles, {.tolerance = 1e-9});
  EXPECT_LT(result.vertex_count, 400);
  EXPECT_LE(test::greatest_distance(grid.positions, result.triangles), 1e-9);
}

TEST(Simplify, HoldsPointsThatNoTriangleNames) {
  test::TriangleMesh grid = test::grid_mesh(20, [](int, int) { return 0.0; });
  grid.positions.emplace_back(10.3, 10.4, 0.05);
  grid.positions.emplace_back(5.3, 10.4, 2.0);
  const SimplifiedMesh result = simplify(grid.positions, grid.triangles, {.tolerance = 0.1});
  EXPECT_EQ(result.strayed_count, 1);
  std::vector<glm::dvec3> near = grid.positions;
  near.pop_back();
  EXPECT_LE(test::greatest_distance(near, result.triangles), 0.1);
}

TEST(Simplify, StopsAtTheTarget) {
  const test::TriangleMesh torus = test::torus_mesh(80, 40);
  EXPECT_EQ(simplify(torus.positions, torus.triangles, {.tolerance = 0.05, .target_vertices = 2000})
                .vertex_count,
            2000);
}

TEST(Simplify, HonoursLimitsOnAnglesAndValence) {
  const test::TriangleMesh torus = test::torus_mesh(80, 40);
  const SimplifiedMesh result = simplify(torus.positions, torus.triangles,
                                         {.tolerance = 0.02, .least_angle = 20, .max_valence = 7});
  EXPECT_GE(least_angle(torus.positions, result.triangles), 20 - 1e-9);
  EXPECT_LE(checked_statistics(torus.positions, result.triangles).valence_counts.size(), 8u);
}

TEST(Simplify, SpacesEvenly) {
  // Flat but for a bump in the middle: adaptive puts all vertices there.
  const test::TriangleMesh grid = test::grid_mesh(40, [](int i, int j) {
    return 2 * std::exp(-0.05 * ((i - 20) * (i - 20) + (j - 20) * (j - 20)));
  });
  const auto largest_ratio = [&](Spacing spacing) {
    const SimplifiedMesh result =
        simplify(grid.positions, grid.triangles, {.tolerance = 0.02, .spacing = spacing});
    std::vector<double> shortest(grid.positions.size(), INFINITY), longest(shortest.size(), 0);
    for (const Triangle& t : result.triangles)
      for (int i = 0; i < 3; ++i)
        for (const std::int32_t v : {t[i], t[(i + 1) % 3]}) {
          const double length = glm::distance(grid.positions[t[i]], grid.positions[t[(i + 1) % 3]]);
          shortest[v] = std::min(shortest[v], length);
          longest[v] = std::max(longest[v], length);
        }
    double ratio = 0;
    for (std::size_t v = 0; v < longest.size(); ++v)
      if (longest[v] > 0) ratio = std::max(ratio, longest[v] / shortest[v]);
    return ratio;
  };
  EXPECT_GT(largest_ratio(Spacing::Adaptive), 4);
  EXPECT_LE(largest_ratio(Spacing::Even), 2.6 + 1e-9);
}

TEST(Simplify, IsTheSameEveryTime) {
  const test::TriangleMesh torus = test::torus_mesh(40, 20);
  const auto run = [&] {
    return simplify(torus.positions, torus.triangles, {.tolerance = 0.02}).triangles;
  };
  EXPECT_EQ(run(), run());
}

TEST(Simplify, RefusesImpossibleOptions) {
  const auto error_of = [](const SimplifyOptions& options) {
    return test::message_of(ErrorCode::InvalidArgument, [&] { (void)simplify({}, {}, options); });
  };
  EXPECT_THAT(error_of({}), HasSubstr("positive length"));
  EXPECT_THAT(error_of({.tolerance = 1, .least_angle = 50}), HasSubstr("min-angle"));
  EXPECT_THAT(error_of({.tolerance = 1, .max_valence = 5}), HasSubstr("max-valence"));
}

}  // namespace
}  // namespace planish
