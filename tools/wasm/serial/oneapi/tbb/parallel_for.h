#pragma once

#include <oneapi/tbb/blocked_range.h>

namespace oneapi::tbb {

struct auto_partitioner {};

template <class Range, class Body>
void parallel_for(const Range& range, const Body& body, auto_partitioner = {}) {
  if (!range.empty()) body(range);
}

}  // namespace oneapi::tbb
