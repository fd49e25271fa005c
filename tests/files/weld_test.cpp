#include "planish/files/shared/weld.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iterator>
#include <numbers>
#include <random>
#include <vector>

namespace planish {
namespace {

TEST(Weld, EqualsInsertingOneAfterAnother) {
  std::mt19937 random(11);
  for (const int distinct : {1, 7, 5000, 200000}) {
    std::vector<glm::dvec3> positions;
    for (int i = 0; i < 150000; ++i) {
      const int k = static_cast<int>(random() % static_cast<unsigned>(distinct));
      positions.emplace_back(k % 50, (k / 50) % 40 * 0.1, k % 3 == 0 ? -0.0 : k * 1e-7);
      if (k % 3 == 0 && random() % 2 == 0) positions.back().z = 0.0;
    }
    Welder welder;
    std::vector<std::int32_t> expected;
    for (const glm::dvec3& position : positions) expected.push_back(welder.insert(position));
    const WeldedPositions welded = weld(positions);
    EXPECT_EQ(std::vector<std::int32_t>(welded.indices.begin(), welded.indices.end()), expected);
    EXPECT_EQ(welded.positions, welder.take_positions());
  }
  EXPECT_TRUE(weld({}).positions.empty());
}

// A ring of revolution as programs make it: its last column stands where the first does, but for
// what rounding leaves of sin(2 pi).
TEST(Weld, ClosesWhatIsOpenByTheRemainderOfAZero) {
  constexpr int kAround = 12;
  std::vector<glm::dvec3> positions;
  for (const double height : {-1.0, 0.0, 1.0}) {
    for (int i = 0; i <= kAround; ++i) {
      const double angle = 2 * std::numbers::pi * i / kAround;
      positions.emplace_back(static_cast<float>(3 * std::cos(angle)), height,
                             static_cast<float>(3 * std::sin(angle)));
    }
  }
  ASSERT_NE(positions[0], positions[kAround]);
  const WeldedPositions welded = weld(positions);
  Welder welder;
  for (std::size_t i = 0; i < positions.size(); ++i)
    EXPECT_EQ(welder.insert(positions[i]), welded.indices[i]);
  EXPECT_EQ(welded.positions.size(), 3U * kAround);
  EXPECT_EQ(welded.positions[0], glm::dvec3(3, -1, 0));
  EXPECT_EQ(welder.take_positions(), welded.positions);
  // Small detail far away is none.
  const glm::dvec3 detail[] = {{1e6, 1e-6, 0}, {1e6, 2e-6, 0}, {0, 1e-300, 0}, {0, 2e-300, 0}};
  EXPECT_EQ(weld(detail).positions, std::vector<glm::dvec3>(std::begin(detail), std::end(detail)));
}

}  // namespace
}  // namespace planish
