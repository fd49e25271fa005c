#pragma once

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>

#include "planish/core/stop.h"

namespace planish {

/// Calls body(begin, end) on disjoint pieces of [0, count), at least `grain` long but the last,
/// on TBB's threads. Pieces vary with the thread count: body must not let results depend on them.
/// Callers limit threads with tbb::task_arena or tbb::global_control. Under a StopScope the pieces
/// are no longer than `grain`, and Error{Cancelled} ends the loop between two of them.
template <class Body>
void parallel_for(std::size_t count, std::size_t grain, const Body& body) {
  if (count <= grain) {
    check_stop();
    if (count > 0) body(std::size_t{0}, count);
    return;
  }
  const StopScope* const stop = AdoptedStop::current();
  oneapi::tbb::parallel_for(
      oneapi::tbb::blocked_range<std::size_t>(0, count, grain),
      [&](const auto& range) {
        const AdoptedStop adopted(stop);
        const std::size_t piece = stop == nullptr ? range.size() : std::max<std::size_t>(grain, 1);
        for (std::size_t begin = range.begin(); begin < range.end(); begin += piece) {
          check_stop();
          body(begin, std::min(begin + piece, range.end()));
        }
      },
      oneapi::tbb::auto_partitioner());
}

}  // namespace planish
