#include "planish/fair/crease_handle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

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
  const dvec3 handle = crease_handle(arms, imbalance(arms));
  EXPECT_NEAR(handle.y, 0, 1e-15);
  EXPECT_NEAR(glm::length(handle), 1.15 * glm::length(arms.before), 1e-15);
  EXPECT_GT(handle.x, 0);
}

TEST(CreaseHandle, IsHalfTheDifferenceOfEvenArms) {
  const CreaseArms arms = arms_of_circle(0.4, 0.4);
  EXPECT_LT(glm::distance(crease_handle(arms, imbalance(arms)), (arms.before - arms.after) / 2.0),
            1e-15);
}

TEST(CreaseHandle, IsFiniteForCuspsAndCoincidentPoints) {
  const dvec3 arm(0.1, 0, 0);
  EXPECT_EQ(crease_handle({arm, arm}, imbalance(CreaseArms{arm, arm})), dvec3(0.0));
  const CreaseArms none{arm, dvec3(0.0)};
  EXPECT_EQ(crease_handle(none, imbalance(none)), dvec3(0.0));
}

}  // namespace
}  // namespace planish::test
