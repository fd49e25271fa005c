#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace planish {

/// Expands LZF data of LibLZF's format to `size` bytes. Empty when the data would read or write
/// out of bounds or gives another size. A size above what the data can expand to is refused before
/// memory is taken.
[[nodiscard]] std::vector<std::byte> expand_lzf(std::span<const std::byte> data, std::size_t size);

}  // namespace planish
