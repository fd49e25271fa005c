#include "planish/reconstruct/spatial_search.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "planish/reconstruct/point_tree.h"
#include "planish/reconstruct/reconstruct_steps.h"
#include "planish/reconstruct/simplify_state.h"
#include "reconstruct/test_clouds.h"

namespace planish {
namespace {

// Of single precision every other time, so that both ways of storing are met.
std::vector<glm::dvec3> cloud_of(std::size_t count, bool single) {
  std::vector<glm::dvec3> points = test::torus_points(count, 3);
  if (single)
    for (glm::dvec3& p : points) p = glm::dvec3(glm::vec3(p));
  return points;
}

TEST(OrderedPoints, KeepPlacesToTheLastBit) {
  for (const bool single : {true, false}) {
    const std::vector<glm::dvec3> given = cloud_of(3000, single);
    OrderedPoints points(given);
    ASSERT_EQ(points.size(), given.size());
    std::vector<std::uint8_t> marks(given.size(), 0);
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_EQ(points[i], given[points.given(i)]);
      marks[i] = i % 3 == 0;
    }
    points.drop(marks);
    ASSERT_EQ(points.size(), 2000u);
    for (std::size_t i = 0; i < points.size(); ++i) EXPECT_EQ(points[i], given[points.given(i)]);
    points.move_to(std::vector<glm::dvec3>(2000, glm::dvec3(0.1)));
    EXPECT_EQ(points[7], glm::dvec3(0.1));
  }
}

TEST(OrderedPoints, DropAllButTheFirstAtOnePlace) {
  std::vector<glm::dvec3> given = test::torus_points(500, 4);
  for (std::size_t i = 0; i < 200; ++i) given.push_back(given[i % 50]);
  given.insert(given.end(), 100, given[499]);  // more than a cell is searched for
  given.emplace_back(0.0, 0, 0);
  given.emplace_back(-0.0, 0, 0);
  OrderedPoints points(given);
  EXPECT_EQ(drop_duplicates(points), 301);
  std::vector<std::int32_t> kept(points.given().begin(), points.given().end()), wanted(500);
  std::ranges::sort(kept);
  std::iota(wanted.begin(), wanted.end(), 0);
  wanted.push_back(800);
  EXPECT_EQ(kept, wanted);
}

// All but a few points lie in one cell of the cloud's cube, and in one of that one's.
TEST(OrderedPoints, FollowACurveInTheSmallestPartOfTheirCube) {
  std::vector<glm::dvec3> points = test::torus_points(2000, 5);
  for (glm::dvec3& p : points) p *= 1e-9;
  points.emplace_back(1e6, 0, 0);
  points.emplace_back(0.01, 0.01, 0);
  const OrderedPoints ordered(points);
  double along = 0, given = 0;
  for (std::size_t i = 1; i < 2000; ++i) {
    along += std::min(glm::distance(ordered[i], ordered[i - 1]), 1e-8);
    given += glm::distance(points[i], points[i - 1]);
  }
  EXPECT_LT(along, 0.1 * given);
}

TEST(OrderedTree, FindsWhatTryingEveryPointFinds) {
  for (const bool single : {true, false}) {
    std::vector<glm::dvec3> given = cloud_of(700, single);
    given.insert(given.end(), 30, given.front());
    const OrderedPoints points(given);
    const OrderedTree tree(points);
    for (std::size_t q = 0; q < points.size(); q += 7) {
      const glm::dvec3 query = points[q] + glm::dvec3(0.01 * static_cast<double>(q % 5), 0, 0.02);
      std::vector<double> expected;
      for (const glm::dvec3& p : given) expected.push_back(glm::dot(p - query, p - query));
      std::ranges::sort(expected);
      for (const std::int32_t start : {static_cast<std::int32_t>(q), 0, 729}) {
        std::vector<Neighbour> nearest(17);
        ASSERT_EQ(tree.find_nearest(query, start, nearest), 17u);
        for (std::size_t i = 0; i < nearest.size(); ++i) {
          EXPECT_EQ(nearest[i].squared_distance, expected[i]);
          const glm::dvec3 difference = points[nearest[i].index] - query;
          EXPECT_EQ(glm::dot(difference, difference), expected[i]);
          // Those that are equally near come by their numbers, wherever the search began.
          if (i > 0 && expected[i] == expected[i - 1]) {
            EXPECT_GT(nearest[i].index, nearest[i - 1].index);
          }
        }
      }
    }
  }
}

TEST(ThinPoints, LeaveNoGapAndNoCrowd) {
  const OrderedPoints points(test::torus_points(4000, 6));
  constexpr double kRadius = 0.15;
  std::vector<std::int32_t> samples = {17, 1900};
  const std::vector<std::int32_t> chosen = thin_points(points, std::nullopt, kRadius, samples);
  EXPECT_TRUE(std::ranges::is_sorted(chosen));
  samples.insert(samples.end(), chosen.begin(), chosen.end());
  for (std::size_t i = 0; i < points.size(); ++i) {
    double nearest = INFINITY;
    for (const std::int32_t sample : samples)
      if (sample != static_cast<std::int32_t>(i))
        nearest = std::min(nearest, glm::distance(points[i], points[sample]));
    const bool is_sample =
        std::ranges::find(samples, static_cast<std::int32_t>(i)) != samples.end();
    EXPECT_EQ(nearest >= kRadius, is_sample);
  }
  // Only among those that are asked for.
  const std::vector<std::int32_t> asked = {5, 6, 7, 3000};
  for (const std::int32_t point : thin_points(points, asked, kRadius, {}))
    EXPECT_TRUE(std::ranges::find(asked, point) != asked.end());
}

TEST(PackedNormal, IsWithinAHundredthOfADegree) {
  for (const glm::dvec3& p : test::torus_points(3000, 7)) {
    const glm::dvec3 unit = glm::normalize(p);
    const glm::dvec3 found(PackedNormal(3.0 * p).get());
    EXPECT_LT(std::asin(glm::length(glm::cross(unit, found))), 1.7e-4);
    EXPECT_GT(glm::dot(unit, found), 0);
  }
  EXPECT_EQ(PackedNormal(glm::dvec3(0.0)).get(), glm::vec3(0.0f));
  EXPECT_EQ(PackedNormal(glm::dvec3(0, 0, -2)).get(), glm::vec3(0, 0, -1));
}

}  // namespace
}  // namespace planish
