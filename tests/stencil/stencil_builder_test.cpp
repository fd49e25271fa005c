#include "planish/solve/stencil_builder.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <map>
#include <random>

namespace planish {
namespace {

TEST(StencilRow, SortsAndMergesAsAMapWould) {
  std::mt19937 random(7);
  for (const int count : {0, 1, 5, 32, 33, 500}) {
    StencilRow row;
    std::map<int, double> expected;
    for (int i = 0; i < count; ++i) {
      const int index = static_cast<int>(random() % 40);
      const double weight = static_cast<double>(random() % 64);
      row.add(index, weight, 2 * weight, -weight);
      expected[index] += weight;
    }
    row.finish();
    ASSERT_EQ(row.entries().size(), expected.size());
    auto entry = row.entries().begin();
    for (const auto& [index, weight] : expected) {
      EXPECT_EQ(entry->index, index);
      EXPECT_EQ(entry->weight, weight);
      EXPECT_EQ(entry->du, 2 * weight);
      EXPECT_EQ(entry->dv, -weight);
      ++entry;
    }
  }
}

StencilTable build(std::int64_t first, std::int64_t count) {
  return build_rows(7, {first, count}, Derivatives::Yes, [] {
    return [](std::int32_t index, StencilRow& row) {
      for (std::int32_t k = 0; k <= index % 7; ++k) row.add(k, index + 0.1 * k, k, index);
    };
  });
}

TEST(BuildRows, IsTheSameForAnyThreadCount) {
  const auto parallel = build(0, 100000);
  const oneapi::tbb::global_control one(oneapi::tbb::global_control::max_allowed_parallelism, 1);
  const auto serial = build(0, 100000);
  EXPECT_EQ(parallel.sizes, serial.sizes);
  EXPECT_EQ(parallel.indices, serial.indices);
  EXPECT_EQ(parallel.weights, serial.weights);
  EXPECT_EQ(parallel.du_weights, serial.du_weights);
  EXPECT_EQ(parallel.dv_weights, serial.dv_weights);
}

TEST(BuildRows, SlicesJoinToTheWhole) {
  const auto whole = build(0, 20000);
  auto joined = build(0, 9000);
  const auto rest = build(9000, 11000);
  joined.weights.insert(joined.weights.end(), rest.weights.begin(), rest.weights.end());
  joined.sizes.insert(joined.sizes.end(), rest.sizes.begin(), rest.sizes.end());
  EXPECT_EQ(joined.weights, whole.weights);
  EXPECT_EQ(joined.sizes, whole.sizes);
}

TEST(BuildRows, MakesAnEmptyTableOfNoRows) {
  const auto rows = build(0, 0);
  EXPECT_TRUE(rows.sizes.empty());
  EXPECT_TRUE(rows.weights.empty());
}

}  // namespace
}  // namespace planish
