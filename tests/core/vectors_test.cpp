#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <random>
#include <utility>

#include "planish/core/group_by.h"
#include "planish/core/raw_vector.h"
#include "planish/core/vectors.h"

namespace planish {
namespace {

TEST(SafeLength, IsInfiniteWhereACoordinateIsNoNumber) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  for (const double none : {kNan, kInfinite, -kInfinite})
    for (int place = 0; place < 3; ++place) {
      glm::dvec3 vector(0.0);
      vector[place] = none;
      EXPECT_EQ(safe_length(vector), kInfinite) << none << " at " << place;
    }
}

TEST(SafeLength, NeitherOverflowsNorUnderflows) {
  EXPECT_DOUBLE_EQ(safe_length({3e300, 0, -4e300}), 5e300);
  EXPECT_DOUBLE_EQ(safe_length({3e-300, 4e-300, 0}), 5e-300);
  EXPECT_EQ(safe_length({0, 0, 0}), 0);
}

TEST(RawVector, FillsOnlyWhereAValueIsGiven) {
  RawVector<float> numbers;
  numbers.resize(3, 2.5f);
  numbers.resize(5, 0.0f);
  EXPECT_EQ(numbers, (RawVector<float>{2.5f, 2.5f, 2.5f, 0.0f, 0.0f}));

  // Memory that is at hand already keeps what was written to it.
  numbers.clear();
  numbers.resize(3);
  EXPECT_EQ(numbers[1], 2.5f);
}

TEST(GroupBy, KeepsTheOrderWithinGroups) {
  std::mt19937 random(3);
  std::vector<std::pair<int, int>> pairs;
  for (int i = 0; i < 1000; ++i) pairs.emplace_back(static_cast<int>(random() % 50) + 3, i);
  const auto groups = group_by<int>(60, [&](const auto& take) {
    for (const auto& [group, value] : pairs) take(group, value);
  });
  std::map<int, std::vector<int>> expected;
  for (const auto& [group, value] : pairs) expected[group].push_back(value);
  ASSERT_EQ(groups.offsets.size(), 61u);
  for (int g = 0; g < 60; ++g) {
    const auto values = groups.of(static_cast<std::size_t>(g));
    EXPECT_EQ(std::vector<int>(values.begin(), values.end()), expected[g]) << g;
  }
}

TEST(GroupBy, TakesNoGroupsAndNoValues) {
  const auto none = [](const auto&) {};
  EXPECT_EQ(group_by<int>(0, none).offsets, (std::vector<std::int32_t>{0}));
  EXPECT_EQ(group_by<int>(2, none).offsets, (std::vector<std::int32_t>{0, 0, 0}));
}

}  // namespace
}  // namespace planish
