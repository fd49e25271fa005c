#pragma once

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <cstddef>

namespace planish {

/// Calls body(begin, end) on disjoint pieces of [0, count), at least `grain` long but the last,
/// on TBB's threads. Pieces vary with the thread count: body must not let results depend on them.
/// Callers limit threads with tbb::task_arena or tbb::global_control.
template <class Body>
void parallel_for(std::size_t count, std::size_t grain, const Body& body) {
  if (count <= grain) {
    if (count > 0) body(std::size_t{0}, count);
    return;
  }
  oneapi::tbb::parallel_for(
      oneapi::tbb::blocked_range<std::size_t>(0, count, grain),
      [&](const auto& range) { body(range.begin(), range.end()); },
      oneapi::tbb::auto_partitioner());
}

}  // namespace planish
