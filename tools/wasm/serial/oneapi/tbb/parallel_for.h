#pragma once

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/task_group.h>

namespace oneapi::tbb {

struct auto_partitioner {};

template <class Range, class Body>
void parallel_for(const Range& range, const Body& body, auto_partitioner, task_group_context&) {
  if (!range.empty()) body(range);
}

}  // namespace oneapi::tbb
