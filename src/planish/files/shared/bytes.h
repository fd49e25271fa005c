#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <span>

namespace planish {

/// The value at the beginning of `bytes`, which must hold sizeof(Value) bytes in the byte order
/// `order`; no alignment is needed.
template <class Value>
[[nodiscard]] Value load(std::span<const std::byte> bytes,
                         std::endian order = std::endian::little) {
  std::array<std::byte, sizeof(Value)> raw;
  std::copy_n(bytes.begin(), sizeof(Value), raw.begin());
  if (order != std::endian::native) std::ranges::reverse(raw);
  return std::bit_cast<Value>(raw);
}

}  // namespace planish
