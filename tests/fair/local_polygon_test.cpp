#include "planish/fair/vertex_polygon.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <random>

namespace planish::test {
namespace {

using glm::dvec2;
using std::int32_t;

TEST(BalancedWeights, BalanceWhatSurroundsTheOrigin) {
  const std::array<dvec2, 4> points{dvec2(3, 0.2), dvec2(0.1, 1), dvec2(-0.5, -0.1), dvec2(0, -2)};
  std::array<double, 4> weights;
  ASSERT_EQ(balance(points, weights), 1);
  dvec2 sum(0.0);
  for (int i = 0; i < 4; ++i) {
    EXPECT_GT(weights[i], 0);
    sum += weights[i] * points[i];
  }
  EXPECT_LT(glm::length(sum), 1e-6);
}

TEST(BalancedWeights, AreOneWhereThePointsBalanceAlready) {
  const std::array<dvec2, 3> points{dvec2(1, 0), dvec2(-0.5, 2), dvec2(-0.5, -2)};
  std::array<double, 3> weights;
  ASSERT_EQ(balance(points, weights), 1);
  for (const double weight : weights) EXPECT_NEAR(weight, 1, 1e-12);
}

TEST(BalancedWeights, RefuseWhatDoesNotSurroundTheOrigin) {
  const std::array<dvec2, 3> one_side{dvec2(1, 0), dvec2(0.5, 2), dvec2(0.5, -2)};
  const std::array<dvec2, 3> nothing{dvec2(0), dvec2(0), dvec2(0)};
  std::array<double, 3> weights;
  EXPECT_EQ(balance(one_side, weights), 0);
  EXPECT_EQ(balance(nothing, weights), 0);
}

// A ring of triangles with uneven angles and edges.
PlanarRing random_ring(std::mt19937& random) {
  const int32_t n = 3 + static_cast<int32_t>(random() % 7);
  const auto unit = [&] { return static_cast<double>(random() % 100000) / 100000; };
  std::vector<double> angles;
  double sum = 0;
  for (int32_t i = 0; i < n; ++i) angles.push_back(sum += 0.3 + unit());
  PlanarRing ring;
  ring.count = n;
  std::vector<dvec2> edges;
  for (const double angle : angles) {
    const double turn = angle / sum * 2 * std::numbers::pi;
    edges.push_back((0.2 + 2 * unit()) * dvec2(std::cos(turn), std::sin(turn)));
  }
  for (int32_t i = 0; i < n; ++i) {
    ring.next.push_back(edges[i]);
    ring.previous.push_back(edges[(i + 1) % n]);
    ring.offsets.push_back((ring.next[i] + ring.previous[i]) / 6.0);
    ring.wedges.push_back(wedge_of(ring.offsets[i], ring.next[i], ring.previous[i]));
    ring.mean += ring.offsets[i] / static_cast<double>(n);
  }
  return ring;
}

TEST(LocalPolygon, KeepsControlPointsInTheirWedgesAroundTheVertex) {
  std::mt19937 random(5);
  int uneven = 0, kept = 0, rings = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const PlanarRing ring = random_ring(random);
    const double rho = imbalance(ring);
    LocalPolygon polygon;
    build_local_polygon(ring, rho, polygon);
    uneven += rho > 0.5;
    bool inside = true;
    dvec2 sum(0.0);
    for (int32_t i = 0; i < ring.count; ++i) {
      const auto wedge = wedge_of(polygon.points[i], ring.next[i], ring.previous[i]);
      inside = inside && wedge.along_next > 0 && wedge.along_previous > 0;
      sum += polygon.points[i];
    }
    if (rho == std::numeric_limits<double>::infinity()) continue;  // an angle of 180 degrees
    ++rings;
    kept += inside && glm::length(sum) < 1e-2;
  }
  EXPECT_GT(uneven, 1000);
  // What is left are rings that surround their vertex only just.
  EXPECT_GT(kept, 0.99 * rings);
}

TEST(LocalPolygon, TwistLeavesPlanesAlone) {
  std::mt19937 random(9);
  PlanarRing ring = random_ring(random);
  LocalPolygon polygon;
  build_local_polygon(ring, 0, polygon);
  std::vector<double> heights;
  for (int32_t i = 0; i < ring.count; ++i) {
    heights.push_back(0.3 + glm::dot(dvec2(0.2, -0.7), ring.offsets[i]));
  }
  add_twist(ring, heights, polygon);
  for (int32_t i = 0; i < ring.count; ++i) EXPECT_NEAR(polygon.heights[i], 0, 1e-12);
}

}  // namespace
}  // namespace planish::test
