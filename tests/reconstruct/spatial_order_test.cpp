#include "planish/reconstruct/point_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "reconstruct/test_clouds.h"

namespace planish {
namespace {

double path_length(const std::vector<glm::dvec3>& points, const std::vector<std::int32_t>& order) {
  double length = 0;
  for (std::size_t i = 1; i < order.size(); ++i)
    length += glm::distance(points[order[i - 1]], points[order[i]]);
  return length;
}

TEST(SpatialOrder, NamesEveryPointOnceAlongAShortWay) {
  const std::vector<glm::dvec3> points = test::torus_points(4000, 3);
  const std::vector<std::int32_t> order = spatial_order(points);
  std::vector<std::int32_t> sorted = order, given(points.size());
  std::ranges::sort(sorted);
  std::iota(given.begin(), given.end(), 0);
  EXPECT_EQ(sorted, given);
  EXPECT_LT(path_length(points, order), 0.1 * path_length(points, given));
}

TEST(SpatialOrder, FollowsTheZOfACube) {
  std::vector<glm::dvec3> corners;
  for (const int i : {5, 0, 7, 2, 4, 1, 6, 3}) corners.emplace_back(i & 1, i >> 1 & 1, i >> 2);
  EXPECT_EQ(spatial_order(corners), (std::vector<std::int32_t>{1, 5, 3, 7, 4, 0, 6, 2}));
}

TEST(SpatialOrder, TakesFlatAndSinglePlaces) {
  EXPECT_TRUE(spatial_order({}).empty());
  const std::vector<glm::dvec3> same(3, glm::dvec3(-1e9, 2, 1e-300));
  EXPECT_EQ(spatial_order(same), (std::vector<std::int32_t>{0, 1, 2}));
}

}  // namespace
}  // namespace planish
