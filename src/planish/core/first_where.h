#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "planish/core/parallel.h"

namespace planish {

/// The smallest i below `count` with test(i), found on all threads; `count` where there is none.
template <class Test>
[[nodiscard]] std::size_t first_where(std::size_t count, const Test& test) {
  constexpr std::size_t kBlock = std::size_t{1} << 13;
  const std::size_t block_count = (count + kBlock - 1) / kBlock;
  std::vector<std::size_t> first(block_count, count);
  parallel_for(block_count, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t block = begin; block < end; ++block) {
      const std::size_t stop = std::min(count, (block + 1) * kBlock);
      for (std::size_t i = block * kBlock; i < stop; ++i) {
        if (!test(i)) continue;
        first[block] = i;
        break;
      }
    }
  });
  return first.empty() ? count : *std::ranges::min_element(first);
}

}  // namespace planish
