#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

namespace planish {

/// Elements 0 to count - 1 in sets that can only be united (union-find with path halving).
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parents_(count) {
    std::iota(parents_.begin(), parents_.end(), 0);
  }

  [[nodiscard]] std::int32_t find(std::int32_t element) {
    while (parents_[element] != element) {
      parents_[element] = parents_[parents_[element]];
      element = parents_[element];
    }
    return element;
  }

  /// False when both were in one set already.
  bool unite(std::int32_t a, std::int32_t b) {
    a = find(a);
    b = find(b);
    if (a == b) return false;
    parents_[std::max(a, b)] = std::min(a, b);
    return true;
  }

 private:
  std::vector<std::int32_t> parents_;
};

}  // namespace planish
