#include "make_scenes/implicit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "make_scenes/implicit.h"
#include "planish/mesh/check.h"
#include "scenes/topology.h"

namespace planish::shapes {
namespace {

double torus_distance(const glm::dvec3& p) {
  return std::hypot(std::hypot(p.x, p.y) - 1.0, p.z) - 0.4;
}

TEST(SurfaceNets, PutEveryVertexOnTheSurface) {
  SurfaceNetsOptions options{
      .low = {-1.503, -1.507, -0.511}, .high = {1.5, 1.5, 0.5}, .cell = 0.08};
  const PolygonMesh mesh = surface_nets(torus_distance, options);
  EXPECT_TRUE(check(mesh).empty());
  EXPECT_EQ(topology_of(mesh).euler_characteristic(), 0);
  for (const glm::dvec3& p : mesh.positions) EXPECT_NEAR(torus_distance(p), 0.0, 1e-9);
  // 2 pi^2 R r^2; an inscribed quad mesh of this fineness misses about 1 %.
  const double volume = 2.0 * std::numbers::pi * std::numbers::pi * 0.16;
  EXPECT_NEAR(volume_of(mesh), volume, 0.02 * volume);
}

// Newton's step where that is no longer than a step may be, else one as long as that.
TEST(SurfaceNets, ProjectFromAfarByStepsOfTheLongestLength) {
  const Field plane = [](const glm::dvec3& p) { return p.x; };
  EXPECT_NEAR(projected(plane, {5.5, 2, 3}, 1).x, 0, 1e-9);
  EXPECT_NEAR(projected(plane, {40, 2, 3}, 1).x, 28, 1e-9);  // after twelve of them
}

TEST(SurfaceNets, FollowTheWarp) {
  SurfaceNetsOptions options{
      .low = {-0.753, -0.757, -0.261}, .high = {0.75, 0.75, 0.25}, .cell = 0.04};
  options.warp = [](const glm::dvec3& p) { return p * 2.0; };
  const PolygonMesh mesh = surface_nets(torus_distance, options);
  EXPECT_EQ(topology_of(mesh).euler_characteristic(), 0);
  for (const glm::dvec3& p : mesh.positions) EXPECT_NEAR(torus_distance(p), 0.0, 1e-9);
}

TEST(Implicit, DistancesMatchHandComputedOnes) {
  EXPECT_DOUBLE_EQ(rounded_box({3.0, 0.0, 0.0}, {1.0, 1.0, 1.0}, 0.2), 2.0);
  EXPECT_DOUBLE_EQ(rounded_box({0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}, 0.2), -1.0);
  EXPECT_DOUBLE_EQ((Cone{{0, 0, 0}, {0, 0, 2}, 0.5, 0.5}({1.0, 0.0, 1.0})), 0.5);
  EXPECT_DOUBLE_EQ((Ellipsoid{{0, 0, 0}, {2, 2, 2}}({3.0, 0.0, 0.0})), 1.5 * 0.5 / 0.75);
  EXPECT_DOUBLE_EQ(extruded(0.5, 0.0, 1.0, 0.1), 0.5);
}

TEST(Implicit, BlendsLeaveFarSurfacesAlone) {
  EXPECT_DOUBLE_EQ(smooth_union(0.1, 0.9, 0.2), 0.1);
  EXPECT_DOUBLE_EQ(smooth_intersection(0.1, 0.9, 0.2), 0.9);
  EXPECT_DOUBLE_EQ(smooth_difference(-0.9, 0.5, 0.2), -0.5);
  EXPECT_LT(smooth_union(0.1, 0.1, 0.2), 0.1);
}

}  // namespace
}  // namespace planish::shapes
