#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
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
  parallel_for(block_count, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b) {
      std::int32_t sum = 0;
      for (const std::int32_t value : block(b)) sum += value;
      starts[b] = sum;
    }
  });
  std::int32_t total = 0;
  for (std::int32_t& start : starts) {
    const std::int32_t sum = start;
    start = total;
    total += sum;
  }
  parallel_for(block_count, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b) {
      std::int32_t sum = starts[b];
      for (std::int32_t& value : block(b)) {
        const std::int32_t own = value;
        value = sum;
        sum += own;
      }
    }
  });
  return total;
}

}  // namespace planish
