#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <span>
#include <vector>

namespace planish::render {

/// The nearest thing at each sample: nearness (larger is nearer) and a number that says what.
struct VisibilityBuffer {
  static constexpr std::uint32_t kNothing = std::numeric_limits<std::uint32_t>::max();

  VisibilityBuffer(int w, int h)
      : width(w),
        height(h),
        nearness(static_cast<std::size_t>(w) * h, std::numeric_limits<float>::lowest()),
        what(static_cast<std::size_t>(w) * h, kNothing) {}

  [[nodiscard]] std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * width + x;
  }

  int width, height;
  std::vector<float> nearness;
  std::vector<std::uint32_t> what;
};

/// Enters triangles, by their number, into rows [row_begin, row_end). Vertices are x, y in samples
/// and nearness; calls on rows that do not overlap may run at once.
void rasterise(std::span<const glm::vec3> vertices, std::span<const std::uint32_t> indices,
               int row_begin, int row_end, VisibilityBuffer& buffer);

}  // namespace planish::render
