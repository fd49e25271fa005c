#include "planish/reconstruct/point_tree.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "reconstruct/test_clouds.h"

namespace planish {
namespace {

TEST(PointTree, FindsWhatTryingEveryPointFinds) {
  std::vector<glm::dvec3> points = test::torus_points(700, 3);
  points.insert(points.end(), 30, points.front());  // more than a leaf at one place
  const PointTree tree(points);
  for (std::size_t q = 0; q < points.size(); q += 7) {
    const glm::dvec3 query = points[q] + glm::dvec3(0.01 * static_cast<double>(q % 5), 0, 0.02);
    std::vector<double> expected;
    for (const glm::dvec3& p : points) expected.push_back(glm::dot(p - query, p - query));
    std::ranges::sort(expected);
    std::vector<Neighbour> nearest(17);
    ASSERT_EQ(tree.find_nearest(query, nearest), 17u);
    for (std::size_t i = 0; i < nearest.size(); ++i) {
      EXPECT_EQ(nearest[i].squared_distance, expected[i]);
      const glm::dvec3 difference = points[nearest[i].index] - query;
      EXPECT_EQ(glm::dot(difference, difference), expected[i]);
    }
  }
}

TEST(PointTree, GivesAllPointsOfASmallCloud) {
  const std::vector<glm::dvec3> points = {{0, 0, 0}, {3, 0, 0}, {1, 0, 0}};
  std::vector<Neighbour> nearest(5);
  ASSERT_EQ(PointTree(points).find_nearest({2.9, 0, 0}, nearest), 3u);
  EXPECT_EQ(nearest[0].index, 1);
  EXPECT_EQ(nearest[1].index, 2);
  EXPECT_EQ(nearest[2].index, 0);
  EXPECT_EQ(PointTree({}).find_nearest({0, 0, 0}, nearest), 0u);
}

}  // namespace
}  // namespace planish
