#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "planish/core/ordered_pipeline.h"
#include "planish/core/range.h"
#include "planish/core/raw_vector.h"

namespace planish {

/// Takes the next bytes of a file.
using ByteSink = std::function<void(std::span<const std::byte>)>;

/// Makes the bytes of each range on all threads, make(range, bytes), and gives them to every sink
/// in the order of the ranges. A sink is called by one thread at a time; different sinks, such as a
/// file and its digest, work side by side. Holds a few pieces at once. Throws what they throw.
template <class Make>
void stream(std::span<const RowRange> ranges, const Make& make, std::span<const ByteSink> sinks) {
  // Enough that no stage waits for another's memory.
  std::vector<RawVector<std::byte>> pieces(pipeline_threads() + sinks.size() + 1);
  std::vector<PieceStep> takers;
  for (const ByteSink& sink : sinks)
    takers.emplace_back([&](std::size_t, std::size_t slot) { sink(pieces[slot]); });
  ordered_pipeline(
      ranges.size(), pieces.size(),
      [&](std::size_t i, std::size_t slot) { make(ranges[i], pieces[slot]); }, takers);
}

/// The values of a piece, `count` of them, for make() to fill.
template <class Value>
std::span<Value> values_of(RawVector<std::byte>& bytes, std::size_t count) {
  bytes.resize(count * sizeof(Value));
  return {reinterpret_cast<Value*>(bytes.data()), count};
}

}  // namespace planish
