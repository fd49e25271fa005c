#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "planish/reconstruct/point_tree.h"
#include "planish/reconstruct/reconstruct_steps.h"
#include "planish/reconstruct/simplify_state.h"
#include "planish/reconstruct/spatial_search.h"
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

// Places near those of the cloud, and those points of it by their distance.
template <class Points, class Check>
void for_queries(const Points& points, const Check& check) {
  for (std::size_t q = 0; q < points.size(); q += 7) {
    const glm::dvec3 query = points[q] + glm::dvec3(0.01 * static_cast<double>(q % 5), 0, 0.02);
    std::vector<double> expected;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const glm::dvec3 difference = points[i] - query;
      expected.push_back(glm::dot(difference, difference));
    }
    std::ranges::sort(expected);
    check(q, query, expected);
  }
}

template <class Points>
void expect_nearest(const Points& points, const glm::dvec3& query,
                    const std::vector<Neighbour>& nearest, const std::vector<double>& expected) {
  for (std::size_t i = 0; i < nearest.size(); ++i) {
    EXPECT_EQ(nearest[i].squared_distance, expected[i]);
    const glm::dvec3 difference = points[nearest[i].index] - query;
    EXPECT_EQ(glm::dot(difference, difference), expected[i]);
  }
}

TEST(PointTree, FindsWhatTryingEveryPointFinds) {
  std::vector<glm::dvec3> points = test::torus_points(700, 3);
  points.insert(points.end(), 30, points.front());  // more than a leaf at one place
  const PointTree tree(points);
  for_queries(points, [&](std::size_t, const glm::dvec3& query, const auto& expected) {
    std::vector<Neighbour> nearest(17);
    ASSERT_EQ(tree.find_nearest(query, nearest), 17u);
    expect_nearest(points, query, nearest, expected);
  });
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
    for_queries(points, [&](std::size_t q, const glm::dvec3& query, const auto& expected) {
      for (const std::int32_t start : {static_cast<std::int32_t>(q), 0, 729}) {
        std::vector<Neighbour> nearest(17);
        ASSERT_EQ(tree.find_nearest(query, start, nearest), 17u);
        expect_nearest(points, query, nearest, expected);
        // Those that are equally near come by their numbers, wherever the search began.
        for (std::size_t i = 1; i < nearest.size(); ++i)
          if (expected[i] == expected[i - 1]) {
            EXPECT_GT(nearest[i].index, nearest[i - 1].index);
          }
      }
    });
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

TEST(TriangleShape, MeasuresEveryRegion) {
  std::mt19937_64 random(9);
  const auto place = [&] {
    const auto unit = [&] { return test::unit_number(random); };
    return glm::dvec3(unit(), unit(), unit());
  };
  for (int i = 0; i < 20000; ++i) {
    const std::array<glm::dvec3, 3> t = {place(), place(), place()};
    const glm::dvec3 p = 3.0 * place() - 1.0;
    EXPECT_NEAR(TriangleShape(t[0], t[1], t[2]).squared_distance(p), test::squared_distance(p, t),
                1e-9);
  }
}

TEST(TriangleShape, ManyPointsAtOnceAreAsOneByOne) {
  const std::vector<glm::dvec3> places = test::torus_points(300, 6);
  PointBatch batch;
  std::vector<double> squared(kPointLanes, INFINITY);
  std::vector<std::int32_t> nearest(kPointLanes, -1);
  for (int i = 0; i < kPointLanes; ++i) {
    const glm::dvec3& p = places[i];
    batch.x[i] = p.x, batch.y[i] = p.y, batch.z[i] = p.z;
    batch.squared_distance[i] = INFINITY;
    batch.nearest[i] = -1;
  }
  for (std::int32_t s = 0; s < 50; ++s) {
    const auto corner = [&](std::int32_t k) { return places[200 + s + k]; };
    // Every fifth has no area.
    const TriangleShape shape(corner(0), corner(1), s % 5 == 0 ? corner(1) : corner(2));
    take_nearer(shape, s, kPointLanes, batch);
    for (std::size_t i = 0; i < squared.size(); ++i)
      if (const double d = shape.squared_distance(places[i]); d < squared[i])
        squared[i] = d, nearest[i] = s;
  }
  EXPECT_EQ(std::vector(batch.squared_distance, batch.squared_distance + kPointLanes), squared);
  EXPECT_EQ(std::vector(batch.nearest, batch.nearest + kPointLanes), nearest);
}

TEST(TriangleShape, TakesNeedles) {
  const glm::dvec3 a(0, 0, 0), b(1, 0, 0), c(3, 0, 0);
  EXPECT_DOUBLE_EQ(TriangleShape(a, b, c).squared_distance({2, 1, 0}), 1);
  EXPECT_DOUBLE_EQ(TriangleShape(a, a, a).squared_distance({2, 1, 0}), 5);
}

TEST(TriangleTree, FindsWhatTryingEveryTriangleFinds) {
  const test::TriangleMesh torus = test::torus_mesh(24, 16);
  const TriangleTree tree(torus.positions, torus.triangles);
  for (const glm::dvec3& p : test::torus_points(500, 4)) {
    double best = INFINITY;
    for (const Triangle& t : torus.triangles)
      best = std::fmin(
          best, test::squared_distance(
                    p, {torus.positions[t[0]], torus.positions[t[1]], torus.positions[t[2]]}));
    const TriangleTree::Hit hit = tree.nearest(p);
    EXPECT_NEAR(hit.squared_distance, best, 1e-14);
    ASSERT_GE(hit.triangle, 0);
  }
  EXPECT_EQ(TriangleTree({}, {}).nearest({0, 0, 0}).triangle, -1);
}

TEST(MeasureDistances, GivesMaximumRmsAndPlace) {
  const std::vector<glm::dvec3> positions = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
  const std::vector<Triangle> triangles = {{0, 1, 2}};
  const std::vector<glm::dvec3> points = {{1, 1, 0}, {1, 1, -4}, {-3, 0, 0}};
  const PointDistances distances = measure_distances(points, positions, triangles);
  EXPECT_DOUBLE_EQ(distances.max, 4);
  EXPECT_DOUBLE_EQ(distances.rms, 5 / std::sqrt(3.0));
  EXPECT_EQ(distances.farthest, 1);
}

}  // namespace
}  // namespace planish
