#include "planish/vulkan/tables/device_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "planish/core/error.h"
#include "shaders/shared.h"
#include "vulkan/tables.h"

namespace planish::testing {
namespace {

using namespace vulkan;

SliceLimits no_limits() {
  SliceLimits limits;
  limits.range.bytes = limits.max_chunks = std::numeric_limits<std::uint64_t>::max();
  return limits;
}

/// Reads the packed slices back as the kernels do; expects every row once, with its own entries.
void expect_same_table(const StencilView<double>& table, const TablePlan& plan) {
  std::vector<int> seen(table.row_count(), 0);
  for (const TableSlice& slice : plan.slices) {
    const PackedSlice packed = pack_slice(table, false, plan, slice);
    for (std::size_t chunk = 0; chunk < slice.chunk_count; ++chunk) {
      const std::uint32_t* head = &packed.chunks[chunk * shared::kChunkWords];
      for (std::uint32_t lane = 0; lane < shared::kChunkRows; ++lane) {
        const std::uint32_t row = head[2 + lane];
        if (row == shared::kNoRow) continue;
        ++seen[row];
        EXPECT_GE(static_cast<std::int32_t>(row), slice.first_row);
        EXPECT_LT(static_cast<std::int32_t>(row), slice.first_row + slice.row_count);
        for (std::uint32_t k = 0; k < head[1]; ++k) {
          const PackedEntry& entry = packed.entries[(head[0] + k) * shared::kChunkRows + lane];
          if (static_cast<std::int32_t>(k) >= table.sizes[row]) {
            EXPECT_EQ(entry.weight, 0);
            continue;
          }
          const std::size_t at = table.offsets[row] + k;
          EXPECT_EQ(static_cast<std::int32_t>(entry.source) + slice.first_source,
                    table.indices[at]);
          EXPECT_EQ(entry.weight, static_cast<float>(table.weights[at]));
        }
      }
    }
  }
  EXPECT_THAT(seen, ::testing::Each(1));
}

TEST(TableSlices, HoldEveryRowOnce) {
  for (const std::int32_t rows : {1, 63, 64, 65, 1023, 1024, 1025, 5000}) {
    const StencilTable table = random_table(rows, rows);
    const TablePlan plan = plan_table(table.view(), no_limits());
    EXPECT_EQ(plan.slices.size(), 1u);
    expect_same_table(table.view(), plan);
  }
}

TEST(TableSlices, AreNoneForAnEmptyTable) {
  EXPECT_TRUE(plan_table(random_table(0, 7).view(), no_limits()).slices.empty());
}

TEST(TableSlices, EndWhereALimitIsReached) {
  // Rows that read near themselves, so that windows of sources are short.
  StencilTable table;
  const std::int32_t count = 10000;
  for (std::int32_t row = 0; row < count; ++row) {
    table.sizes.push_back(4);
    for (std::int32_t k = 0; k < 4; ++k) {
      table.indices.push_back(std::min(row + 100 * k, count - 1));
      table.weights.push_back(0.25);
    }
  }
  table.close(count);
  SliceLimits by_range = no_limits(), by_chunks = no_limits();
  by_range.range.bytes = 2 * 1024 * 4 * sizeof(PackedEntry);
  by_chunks.max_chunks = 40;  // two windows of 16 chunks
  for (const SliceLimits& limits : {by_range, by_chunks}) {
    const TablePlan plan = plan_table(table.view(), limits);
    EXPECT_EQ(plan.slices.size(), 5u);
    expect_same_table(table.view(), plan);
    for (const TableSlice& slice : plan.slices) {
      EXPECT_LE(slice.row_count, 2048);
      EXPECT_LE(slice.source_count, 2048 + 300 + 64);
      EXPECT_EQ(slice.first_source % 64, 0);
    }
  }
}

TEST(TableSlices, ShrinkToSingleChunksWhereLimitsAreLow) {
  const StencilTable table = random_table(200, 100);
  SliceLimits limits = no_limits();
  limits.range.bytes = 12 * 64 * sizeof(PackedEntry);  // the longest rows, 64 of them
  const TablePlan plan = plan_table(table.view(), limits);
  EXPECT_EQ(plan.slices.size(), 4u);
  expect_same_table(table.view(), plan);
}

TEST(TableSlices, RefuseByTheNameOfTheLimit) {
  const StencilTable table = random_table(5000, 5000);
  SliceLimits by_range = no_limits(), by_chunks = no_limits();
  by_range.range.bytes = 5000;
  by_chunks.max_chunks = 0;
  const std::pair<SliceLimits, const char*> cases[] = {
      {by_range, "maxStorageBufferRange is 5000"},
      {by_chunks, "maxComputeWorkGroupCount allows 0"}};
  for (const auto& [limits, words] : cases) try {
      static_cast<void>(plan_table(table.view(), limits));
      FAIL() << words;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::OutOfMemory);
      EXPECT_EQ(error.element(), 0);
      EXPECT_THAT(error.what(), ::testing::HasSubstr(words));
    }
}

}  // namespace
}  // namespace planish::testing
