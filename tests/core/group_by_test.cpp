#include "planish/core/group_by.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <utility>

namespace planish {
namespace {

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
