#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <glm/vec3.hpp>
#include <span>

namespace planish {

/// Of a B-spline of a degree up to kMost, by de Boor's scheme; point(i) is the control point i.
/// Knots are distinct, the first and last of which count degree + 1 times.
template <std::size_t kMost, class Point>
[[nodiscard]] glm::dvec3 spline_point(std::size_t degree, std::span<const double> knots,
                                      const Point& point, double t) {
  const auto above = std::upper_bound(knots.begin() + 1, knots.end() - 1, t);
  const auto span = static_cast<std::size_t>(above - knots.begin()) - 1;
  const auto knot = [&](std::size_t k) {
    return knots[std::min(k < degree ? 0 : k - degree, knots.size() - 1)];
  };
  std::array<glm::dvec3, kMost + 1> left;
  for (std::size_t i = 0; i <= degree; ++i) left[i] = point(span + i);
  for (std::size_t r = 1; r <= degree; ++r) {
    for (std::size_t i = 0; i + r <= degree; ++i) {
      const double low = knot(span + i + r), high = knot(span + i + degree + 1);
      const double part = (t - low) / (high - low);
      left[i] = (1 - part) * left[i] + part * left[i + 1];
    }
  }
  return left[0];
}

}  // namespace planish
