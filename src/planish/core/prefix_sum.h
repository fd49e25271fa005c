#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "planish/core/parallel.h"

namespace planish {

/// Replaces each value by the sum of those before it and returns the sum of all, on all threads.
/// The sums must fit 32 bits.
inline std::int32_t exclusive_sum(std::span<std::int32_t> values) {
  constexpr std::size_t kBlock = 1 << 16;
  const std::size_t block_count = (values.size() + kBlock - 1) / kBlock;
  const auto block = [&](std::size_t b) {
    return values.subspan(b * kBlock, std::min(kBlock, values.size() - b * kBlock));
  };
  std::vector<std::int32_t> starts(block_count);
  parallel_each(block_count, 1, [&](std::size_t b) {
    const std::span<std::int32_t> own = block(b);
    starts[b] = std::accumulate(own.begin(), own.end(), 0);
  });
  const std::int32_t total = std::accumulate(starts.begin(), starts.end(), 0);
  std::exclusive_scan(starts.begin(), starts.end(), starts.begin(), 0);
  parallel_each(block_count, 1, [&](std::size_t b) {
    const std::span<std::int32_t> own = block(b);
    std::exclusive_scan(own.begin(), own.end(), own.begin(), starts[b]);
  });
  return total;
}

/// Where each block of elements begins to number those selected of it.
struct SelectedBlocks {
  std::vector<std::int32_t> starts;
  std::int32_t total = 0;
};

/// How many of `count` elements select(i) is true for, on all threads; the blocks are for
/// for_selected().
template <class Select>
SelectedBlocks count_selected(std::size_t count, const Select& select) {
  constexpr std::size_t kBlock = 1 << 16;
  SelectedBlocks blocks;
  blocks.starts.resize((count + kBlock - 1) / kBlock);
  parallel_each(blocks.starts.size(), 1, [&](std::size_t b) {
    std::int32_t sum = 0;
    for (std::size_t i = b * kBlock; i < std::min(count, (b + 1) * kBlock); ++i)
      sum += select(i) ? 1 : 0;
    blocks.starts[b] = sum;
  });
  blocks.total = exclusive_sum(blocks.starts);
  return blocks;
}

/// Calls visit(i, number) for each selected element, numbered in their order, on all threads.
template <class Select, class Visit>
void for_selected(std::size_t count, const SelectedBlocks& blocks, const Select& select,
                  const Visit& visit) {
  constexpr std::size_t kBlock = 1 << 16;
  parallel_each(blocks.starts.size(), 1, [&](std::size_t b) {
    std::int32_t number = blocks.starts[b];
    for (std::size_t i = b * kBlock; i < std::min(count, (b + 1) * kBlock); ++i)
      if (select(i)) visit(i, number++);
  });
}

}  // namespace planish
