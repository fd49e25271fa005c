#include "planish/files/tiles/tile.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <cstdlib>
#include <random>
#include <set>

namespace planish {
namespace {

TEST(CurveOrder, CellsThatFollowOneAnotherShareAFace) {
  // The 16^3 largest cubes of the curve, by any of their cells, in its order.
  struct Cube {
    std::uint64_t key;
    int x, y, z;
  };
  std::vector<Cube> cubes;
  for (int x = 0; x < 16; ++x)
    for (int y = 0; y < 16; ++y)
      for (int z = 0; z < 16; ++z) {
        const auto cell = [](int i) { return static_cast<std::uint32_t>(i) << (kCurveBits - 4); };
        cubes.push_back({hilbert_key(cell(x), cell(y), cell(z)) >> 3 * (kCurveBits - 4), x, y, z});
      }
  std::ranges::sort(cubes, {}, &Cube::key);
  for (std::size_t i = 0; i < cubes.size(); ++i) {
    ASSERT_EQ(cubes[i].key, i);  // each place once
    if (i == 0) continue;
    const Cube &a = cubes[i - 1], &b = cubes[i];
    ASSERT_EQ(std::abs(a.x - b.x) + std::abs(a.y - b.y) + std::abs(a.z - b.z), 1) << i;
  }
}

TEST(CurveOrder, SmallestCellsShareAFaceToo) {
  // A corner of 8 cells has 8 places that follow one another.
  std::set<std::uint64_t> keys;
  for (std::uint32_t i = 0; i < 8; ++i)
    keys.insert(hilbert_key(1234560 + (i & 1), 42 + (i >> 1 & 1), 2000000 + (i >> 2)));
  EXPECT_EQ(keys.size(), 8u);
  EXPECT_EQ(*keys.rbegin() - *keys.begin(), 7u);
  EXPECT_EQ(*keys.begin() % 8, 0u);
  EXPECT_LT(hilbert_key(0x1fffff, 0x1fffff, 0x1fffff), std::uint64_t{1} << 63);
}

TEST(CurveOrder, PointsOfOnePlaceKeepTheirOrder) {
  const std::vector<glm::dvec3> points{{1, 0, 0}, {0, 0, 0}, {1, 0, 0}, {0, 0, 0}};
  const auto order = curve_order(points);
  EXPECT_EQ(order, (std::vector<std::int32_t>{1, 3, 0, 2}));
  const std::vector<glm::dvec3> same(3, glm::dvec3(7.0));
  EXPECT_EQ(curve_order(same), (std::vector<std::int32_t>{0, 1, 2}));
}

TEST(CurveOrder, DoesNotDependOnThreads) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> coordinate(-3, 3);
  std::vector<glm::dvec3> points(50'000);
  for (glm::dvec3& p : points) p = {coordinate(random), coordinate(random), coordinate(random)};
  for (std::size_t i = 0; i < 1000; ++i) points[49'999 - i] = points[i];
  using oneapi::tbb::global_control;
  const auto with = [&](std::size_t threads) {
    const global_control limit(global_control::max_allowed_parallelism, threads);
    return curve_order(points);
  };
  const auto one = with(1);
  EXPECT_EQ(one, with(2));
  EXPECT_EQ(one, with(5));
  auto sorted = one;
  std::ranges::sort(sorted);
  for (std::size_t i = 0; i < sorted.size(); ++i) ASSERT_EQ(sorted[i], static_cast<int>(i));
}

}  // namespace
}  // namespace planish
