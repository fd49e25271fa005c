#pragma once

#include <algorithm>
#include <iterator>

namespace oneapi::tbb {

template <class Iterator>
void parallel_sort(Iterator begin, Iterator end) {
  std::sort(begin, end);
}

template <class Range, class Less>
void parallel_sort(Range& range, const Less& less) {
  std::sort(std::begin(range), std::end(range), less);
}

}  // namespace oneapi::tbb
