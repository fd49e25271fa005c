#pragma once

#include <cstdint>
#include <ranges>
#include <span>
#include <vector>

namespace planish {

/// The entries of an array that `indices` name, in that order.
template <std::ranges::random_access_range Array>
[[nodiscard]] auto chosen(const Array& array, std::span<const std::int32_t> indices) {
  std::vector<std::ranges::range_value_t<Array>> result;
  result.reserve(indices.size());
  for (const std::int32_t index : indices) result.push_back(array[index]);
  return result;
}

}  // namespace planish
