#include "planish/reconstruct/reconstruct.h"

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
#include "reconstruct/test_clouds.h"
#include "support/expect_error.h"

namespace planish {
namespace {

using testing::HasSubstr;

MeshStatistics checked_statistics(const std::vector<glm::dvec3>& positions,
                                  const std::vector<Triangle>& triangles) {
  PolygonMesh mesh = polygons_of(triangles);
  mesh.positions = positions;
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
