#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

#include "fair/fair_case.h"
#include "planish/fair/fair_topology.h"
#include "planish/fair/vertex_polygon.h"
#include "support/outlines.h"

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

using glm::dvec3;

// The vertex at the bottom of a unit circle, its neighbours at two angles to either side.
CreaseArms arms_of_circle(double before, double after) {
  const auto point = [](double angle) { return dvec3(std::sin(angle), 1 - std::cos(angle), 0); };
  return {point(before) / 4.0, point(-after) / 4.0};
}

TEST(CreaseHandle, IsTangentToTheCircleThroughUnevenNeighbours) {
  const CreaseArms arms = arms_of_circle(0.3, 0.9);
  const dvec3 handle = crease_handle(arms);
  EXPECT_NEAR(handle.y, 0, 1e-15);
  EXPECT_NEAR(glm::length(handle), 1.15 * glm::length(arms.before), 1e-15);
  EXPECT_GT(handle.x, 0);
}

TEST(CreaseHandle, IsAsLongAsEvenArms) {
  const CreaseArms arms = arms_of_circle(0.4, 0.4);
  EXPECT_LT(glm::distance(crease_handle(arms), dvec3(glm::length(arms.before), 0, 0)), 1e-15);
}

TEST(CreaseHandle, IsFiniteForCuspsAndCoincidentPoints) {
  const dvec3 arm(0.1, 0, 0);
  EXPECT_EQ(crease_handle({arm, arm}), dvec3(0.0));
  EXPECT_EQ(crease_handle({arm, dvec3(0.0)}), dvec3(0.0));
}

// By what a handle at corner 0 of a polygon in the plane z = 0, which leads along its first edge or
// from its last one, is multiplied.
double corridor(const std::vector<dvec3>& polygon, const dvec3& handle) {
  std::vector<int32_t> face(polygon.size());
  std::iota(face.begin(), face.end(), 0);
  const FairCase c(make_mesh(polygon, {face}));
  return corridor_factor(c.topology, polygon, GivenStep(c.topology, polygon),
                         unit_face_normals(c.topology, polygon), 0,
                         c.topology.crease_neighbours(0)[0] == 1 ? handle : -handle);
}

// The corner passes through a straight angle, and the handle leads into it.
double factor_at_corner(double degrees) {
  const double angle = degrees * std::numbers::pi / 180;
  const dvec3 last(0.7 * std::cos(angle), 0.7 * std::sin(angle), 0);
  return corridor({{0, 0, 0}, {1, 0, 0}, {1, 2, 0}, {-1, 2, 0}, last}, {0.2, 0.1, 0});
}

TEST(CreaseHandle, KeepsToItsCorridorContinuouslyThroughStraightCorners) {
  // Into a corner of 100 degrees by an eighth of its other edge's height.
  EXPECT_NEAR(factor_at_corner(100), 0.7 * std::sin(100 * std::numbers::pi / 180) / 8 / 0.1, 1e-12);
  double before = factor_at_corner(100);
  for (double degrees = 100.1; degrees < 260; degrees += 0.1) {
    const double factor = factor_at_corner(degrees);
    EXPECT_NEAR(factor, before, 0.01) << degrees;
    EXPECT_GT(factor, 0.025) << degrees;  // nowhere at the least that is left, 0.02
    before = factor;
  }
}

// Of a triangle by half of what its Doo-Sabin point does, which is a sixth of its height away.
TEST(CreaseHandle, LeadsLessFarIntoTriangles) {
  EXPECT_NEAR(corridor({{0, 0, 0}, {1, 0, 0}, {0.2, 0.9, 0}}, {0.2, 0.15, 0}), 0.9 / 12 / 0.15,
              1e-12);
}

// Beside a long side the handle is far shorter than the side's quarter. What follows it deep in the
// face must not overtake the points beside it (the corner at a side's end lay 21 times the side's
// length away).
TEST(CreaseSector, KeepsTheOrderOfALargeFacesPoints) {
  for (const int steps : {4, 16, 32, 100}) {
    SCOPED_TRACE(steps);
    const FairCase c(with_sharp_rims(prism_over(rounded_square(steps, 0.5))));
    const FairNet net =
        fair_net(c.mesh, c.subdivision, c.given, {.polish_steps = 0, .cures_folds = false});
    const std::int32_t count = c.mesh.face_size(0);
    for (std::int32_t i = 0; i < count; ++i) {
      const glm::dvec3 &own = net.state[i], &next = net.state[(i + 1) % count];
      EXPECT_GT(own.x * next.y - own.y * next.x, 0) << i;
      EXPECT_LT(glm::length(glm::dvec2(own)), glm::length(glm::dvec2(c.given[i]))) << i;
    }
  }
}

dvec3 normal_at(const FairCase& c, int32_t vertex) {
  return angle_weighted_normal(c.topology, c.given, c.face_normals, vertex,
                               c.topology.ring(vertex));
}

TEST(VertexNormal, CountsInwardCornersByTheirWholeAngle) {
  const FairCase c(prism_over({{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}}));
  // 270 degrees of the top, 90 of each of the two walls of the dent.
  const dvec3 wanted = glm::normalize(dvec3(1, 1, 3));
  EXPECT_LT(glm::distance(normal_at(c, 3), wanted), 1e-12);
  // An outward corner: 90 of each.
  EXPECT_LT(glm::distance(normal_at(c, 2), glm::normalize(dvec3(1, 1, 1))), 1e-12);
}

// A face above two that together have its angle: the sum by angles is what a tilt of 1e-7 leaves.
TEST(VertexNormal, IsTheMeanOfItsFacesWhereAnglesCancel) {
  PolygonMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 1e-7}};
  for (const auto& face : {std::array{0, 1, 2}, {0, 2, 3}, {0, 3, 1}}) mesh.add_face(face);
  const FairCase c(mesh);
  dvec3 sum(0.0);
  for (const auto& [a, b] : {std::pair{1, 2}, {2, 3}, {3, 1}})
    sum += glm::normalize(glm::cross(c.given[a] - c.given[0], c.given[b] - c.given[0]));
  EXPECT_LT(glm::distance(normal_at(c, 0), glm::normalize(sum)), 1e-12);
}

TEST(VertexNormal, TakesNearlyStraightCornersByTheirFace) {
  for (const double dent : {-1e-9, 0.0, 1e-9}) {
    // The middle of the front edge of the top: half a turn of it, a quarter of each wall below.
    const FairCase c(prism_over({{0, 0}, {1, dent}, {2, 0}, {2, 2}, {0, 2}}));
    EXPECT_LT(glm::distance(normal_at(c, 1), glm::normalize(dvec3(0, -1, 1))), 1e-8) << dent;
  }
}

TEST(VertexNormal, ChangesContinuouslyThroughAStraightCorner) {
  dvec3 before(0.0);
  for (int step = -200; step <= 200; ++step) {
    PolygonMesh mesh = prism_over({{0, 0}, {1, 0.001 * step}, {2, 0}, {2, 3}, {0, 3}});
    mesh.positions[1].z += 0.2;  // off the plane of the top
    const dvec3 normal = normal_at(FairCase(mesh), 1);
    if (step > -200) {
      EXPECT_LT(glm::distance(normal, before), 0.01) << step;
    }
    before = normal;
  }
}

}  // namespace
}  // namespace planish::test
