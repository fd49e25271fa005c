#include "planish/fair/vertex_polygon.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <vector>

#include "fair/fair_case.h"
#include "planish/fair/fair_topology.h"

namespace planish::test {
namespace {

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

// A boundary vertex of one polygon whose corner passes through a straight angle, and a handle that
// leads into it.
double factor_at_corner(double degrees) {
  const double angle = degrees * std::numbers::pi / 180;
  PolygonMesh mesh;
  mesh.positions = {{0, 0, 0},
                    {1, 0, 0},
                    {1, 2, 0},
                    {-1, 2, 0},
                    {0.7 * std::cos(angle), 0.7 * std::sin(angle), 0}};
  mesh.add_face(std::array{0, 1, 2, 3, 4});
  const FairCase c(mesh);
  const FairTopology topology = make_fair_topology(c.mesh, c.subdivision);
  const std::vector<dvec3> normals = unit_face_normals(topology, mesh.positions);
  return corridor_factor(
      topology, mesh.positions, GivenStep(topology, mesh.positions), normals, 0,
      topology.crease_neighbours(0)[0] == 1 ? dvec3(0.2, 0.1, 0) : dvec3(-0.2, -0.1, 0));
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
  PolygonMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0.2, 0.9, 0}};
  mesh.add_face(std::array{0, 1, 2});
  const FairCase c(mesh);
  const FairTopology topology = make_fair_topology(c.mesh, c.subdivision);
  const dvec3 handle =
      topology.crease_neighbours(0)[0] == 1 ? dvec3(0.2, 0.15, 0) : dvec3(-0.2, -0.15, 0);
  EXPECT_NEAR(corridor_factor(topology, mesh.positions, GivenStep(topology, mesh.positions),
                              unit_face_normals(topology, mesh.positions), 0, handle),
              0.9 / 12 / 0.15, 1e-12);
}

}  // namespace
}  // namespace planish::test
