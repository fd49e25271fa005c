#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"

namespace planish {

/// Elements 0 to count - 1 in sets that can only be united, by any number of threads at once. Which
/// sets arise does not depend on the order. Based on: Anderson & Woll, "Wait-free parallel
/// algorithms for the union-find problem", 1991.
class ConcurrentSets {
 public:
  explicit ConcurrentSets(std::size_t count) : parents_(count) {
    parallel_each(count, 4096, [&](std::int32_t i) { parents_[i] = i; });
  }

  /// False when both were in one set already: true is answered as often as sets vanish.
  bool unite(std::int32_t a, std::int32_t b) {
    while (true) {
      a = find(a);
      b = find(b);
      if (a == b) return false;
      if (a < b) std::swap(a, b);  // roots have the lowest number
      std::int32_t root = a;
      if (place(a).compare_exchange_strong(root, b, std::memory_order_relaxed)) return true;
    }
  }

  /// The lowest element of its set, once no thread unites any.
  [[nodiscard]] std::int32_t find(std::int32_t element) {
    std::int32_t parent = place(element).load(std::memory_order_relaxed);
    while (parent != element) {
      // Halves the path; a parent that another thread has changed meanwhile may stay.
      const std::int32_t above = place(parent).load(std::memory_order_relaxed);
      if (above == parent) return parent;
      std::int32_t expected = parent;
      place(element).compare_exchange_weak(expected, above, std::memory_order_relaxed);
      element = above;
      parent = place(element).load(std::memory_order_relaxed);
    }
    return element;
  }

 private:
  [[nodiscard]] std::atomic_ref<std::int32_t> place(std::int32_t element) {
    return std::atomic_ref(parents_[element]);
  }

  RawVector<std::int32_t> parents_;
};

}  // namespace planish
