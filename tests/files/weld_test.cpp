#include "planish/files/shared/weld.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace planish
