#pragma once

#include <algorithm>
#include <cmath>

namespace planish::vulkan {

/// The largest float whose square root, in double, is at most `stop_error`, so that the kernel's
/// comparison and one of the reported errors agree. Negative: never stop.
[[nodiscard]] inline float stop_square_of(double stop_error) noexcept {
  if (!(stop_error >= 0)) return -1;
  auto square = static_cast<float>(stop_error * stop_error);
  while (std::sqrt(static_cast<double>(square)) > stop_error)
    square = std::nextafter(square, -1.0f);
  return std::max(square, 0.0f);
}

}  // namespace planish::vulkan
