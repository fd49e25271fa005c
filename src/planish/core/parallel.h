#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

namespace planish {

/// A body of parallel_for() that its caller keeps. The loop takes it by this, so that its tasks are
/// compiled once for all bodies.
struct LoopBody {
  const void* object;
  void (*call)(const void* object, std::size_t begin, std::size_t end);
};

/// What parallel_for() does with it.
void run_loop(std::size_t count, std::size_t grain, LoopBody body);

/// Calls body(begin, end) on disjoint pieces of [0, count), at least `grain` long but the last,
/// on TBB's threads. Pieces vary with the thread count: body must not let results depend on them.
/// Callers limit threads with tbb::task_arena or tbb::global_control. Under a StopScope the pieces
/// are no longer than `grain`, and Error{Cancelled} ends the loop between two of them. It returns
/// when all pieces are done, or throws: an error in a loop around it leaves none of them out.
template <class Body>
void parallel_for(std::size_t count, std::size_t grain, const Body& body) {
  run_loop(count, grain, {&body, [](const void* object, std::size_t begin, std::size_t end) {
                            (*static_cast<const Body*>(object))(begin, end);
                          }});
}

/// The same one by one: calls body(i) for each i in [0, count).
template <class Body>
void parallel_each(std::size_t count, std::size_t grain, const Body& body) {
  parallel_for(count, grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) body(i);
  });
}

/// For bodies of a few hundred cycles or less.
template <class Body>
void parallel_each(std::size_t count, const Body& body) {
  parallel_each(count, 4096, body);
}

/// Calls of_range(begin, end) for pieces of [0, count) that are `piece` long, the last as long as
/// is left, on all threads, and join(total, result) with each result in the pieces' order. Returns
/// the total: the same bits for every thread count. of_range must return the same type as `total`.
template <class Total, class OfRange, class Join>
[[nodiscard]] Total ordered_reduce(std::size_t count, std::size_t piece, Total total,
                                   const OfRange& of_range, const Join& join) {
  std::vector<Total> results((count + piece - 1) / piece);
  parallel_each(results.size(), 1, [&](std::size_t p) {
    results[p] = of_range(p * piece, std::min((p + 1) * piece, count));
  });
  for (const Total& result : results) join(total, result);
  return total;
}

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

/// Leaves the values that are not marked, in their order. One mark a value.
template <class Values>
void drop_marked(Values& values, std::span<const std::uint8_t> is_dropped) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!is_dropped[i]) values[kept++] = values[i];
  values.resize(kept);
}

}  // namespace planish
