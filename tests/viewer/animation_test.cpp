#include "viewer/scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "support/meshes.h"

namespace planish::testing {
namespace {

using viewer::Animation;

TEST(Animation, BeginsAtRest) {
  const PolygonMesh mesh = test::torus(9, 6, 2, 0.7);
  std::vector<glm::vec3> points(mesh.positions.size());
  Animation(mesh.positions).pose(0, points);
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_LT(glm::distance(glm::dvec3(points[i]), mesh.positions[i]), 1e-6) << i;
}

TEST(Animation, MovesSmoothly) {
  const PolygonMesh mesh = test::torus(9, 6, 2, 0.7);
  const Animation animation(mesh.positions);
  std::vector<glm::vec3> before(mesh.positions.size()), points(before), after(before);
  constexpr double kStep = 1 / 60.0;
  // Accelerations in diameters a second squared stay below those of the formula's terms.
  constexpr double kMostAcceleration = 2, kDiameter = 5.4;
  double farthest = 0;
  for (int frame = 1; frame < 420; ++frame) {
    animation.pose((frame - 1) * kStep, before);
    animation.pose(frame * kStep, points);
    animation.pose((frame + 1) * kStep, after);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double bend = glm::length(after[i] - 2.0f * points[i] + before[i]);
      ASSERT_LT(bend, kMostAcceleration * kDiameter * kStep * kStep) << frame;
      farthest = std::max(farthest, glm::distance(glm::dvec3(points[i]), mesh.positions[i]));
    }
  }
  EXPECT_GT(farthest, 0.05 * kDiameter);
}

TEST(Animation, FlatShapesStayFinite) {
  const std::vector<glm::dvec3> flat{{0, 1, 0}, {1, 1, 0}, {1, 1, 1}};
  std::vector<glm::vec3> points(flat.size());
  Animation(flat).pose(1, points);
  for (const glm::vec3& p : points) {
    EXPECT_TRUE(std::isfinite(p.x) && std::isfinite(p.z));
    EXPECT_EQ(p.y, 1);
  }
}

}  // namespace
}  // namespace planish::testing
