#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace planish {

/// Leaves the values that are not marked, in their order. One mark a value.
template <class Values>
void drop_marked(Values& values, std::span<const std::uint8_t> is_dropped) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!is_dropped[i]) values[kept++] = values[i];
  values.resize(kept);
}

}  // namespace planish
