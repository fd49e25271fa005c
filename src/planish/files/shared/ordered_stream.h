#pragma once

#include <oneapi/tbb/parallel_pipeline.h>
#include <oneapi/tbb/task_arena.h>

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "planish/core/range.h"
#include "planish/core/raw_vector.h"
#include "planish/core/stop.h"

namespace planish {

/// Takes the next bytes of a file.
using ByteSink = std::function<void(std::span<const std::byte>)>;

/// Makes the bytes of each range on all threads, make(range, bytes), and gives them to every sink
/// in the order of the ranges. A sink is called by one thread at a time; different sinks, such as a
/// file and its digest, work side by side. Holds a few pieces at once. Throws what they throw.
template <class Make>
void stream(std::span<const RowRange> ranges, const Make& make, std::span<const ByteSink> sinks) {
  namespace tbb = oneapi::tbb;
  // Enough that no stage waits for another's memory.
  const auto slots =
      static_cast<std::size_t>(tbb::this_task_arena::max_concurrency()) + sinks.size() + 1;
  std::vector<RawVector<std::byte>> pieces(slots);
  std::size_t next = 0;
  const StopScope* const stop = AdoptedStop::current();
  tbb::filter<void, std::size_t> chain =
      tbb::make_filter<void, std::size_t>(tbb::filter_mode::serial_in_order,
                                          [&](tbb::flow_control& control) -> std::size_t {
                                            if (next == ranges.size()) control.stop();
                                            return next++;
                                          }) &
      tbb::make_filter<std::size_t, std::size_t>(tbb::filter_mode::parallel, [&](std::size_t i) {
        const AdoptedStop adopted(stop);
        check_stop();
        make(ranges[i], pieces[i % slots]);
        return i;
      });
  for (const ByteSink& sink : sinks) {
    chain = chain & tbb::make_filter<std::size_t, std::size_t>(tbb::filter_mode::serial_in_order,
                                                               [&](std::size_t i) {
                                                                 const AdoptedStop adopted(stop);
                                                                 sink(pieces[i % slots]);
                                                                 return i;
                                                               });
  }
  tbb::parallel_pipeline(slots, chain & tbb::make_filter<std::size_t, void>(
                                            tbb::filter_mode::serial_in_order, [](std::size_t) {}));
}

/// The values of a piece, `count` of them, for make() to fill.
template <class Value>
std::span<Value> values_of(RawVector<std::byte>& bytes, std::size_t count) {
  bytes.resize(count * sizeof(Value));
  return {reinterpret_cast<Value*>(bytes.data()), count};
}

}  // namespace planish
