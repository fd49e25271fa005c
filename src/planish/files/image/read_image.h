#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace planish {

/// 8-bit RGB, top row first.
struct RgbImage {
  int width = 0, height = 0;
  std::vector<std::uint8_t> pixels;

  [[nodiscard]] const std::uint8_t* at(int x, int y) const {
    return pixels.data() + 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                                static_cast<std::size_t>(x));
  }
};

/// The largest image that is read, in pixels along a side: what the largest texture of a device is.
inline constexpr int kMostImageSide = 16384;

/// A PNG or a JPEG, of any depth; grey becomes RGB, alpha is left out. Empty where it is neither,
/// is damaged, or has a side above kMostImageSide: its size is looked at before memory is taken.
[[nodiscard]] std::optional<RgbImage> read_image(std::span<const std::byte> bytes);

}  // namespace planish
