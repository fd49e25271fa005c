#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <span>

namespace planish {

/// Around points; of none it is turned inside out.
struct FloatBox {
  glm::vec3 minimum{std::numeric_limits<float>::infinity()};
  glm::vec3 maximum{-std::numeric_limits<float>::infinity()};
  bool is_finite = true;  ///< all coordinates are; if not, the rest means nothing

  void add(const glm::vec3& point) {
    minimum = glm::min(minimum, point);
    maximum = glm::max(maximum, point);
  }
  /// Two boxes as one, of finite points.
  void add(const FloatBox& other) {
    minimum = glm::min(minimum, other.minimum);
    maximum = glm::max(maximum, other.maximum);
  }
};

/// The bounds of some points, four of them at a time as three vectors of four floats.
[[nodiscard]] inline FloatBox box_of(std::span<const glm::vec3> points) {
  typedef float Four __attribute__((vector_size(16)));
  typedef std::int32_t Flags __attribute__((vector_size(16)));
  static_assert(sizeof(glm::vec3) == 12);
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  Four low[3], high[3];
  for (int v = 0; v < 3; ++v) {
    low[v] = Four{} + kInfinity;
    high[v] = Four{} - kInfinity;
  }
  Flags finite = ~Flags{};
  const std::size_t fours = points.size() / 4 * 4;
  for (std::size_t i = 0; i < fours; i += 4) {
    Four values[3];
    std::memcpy(values, &points[i], sizeof(values));
    for (int v = 0; v < 3; ++v) {
      low[v] = values[v] < low[v] ? values[v] : low[v];
      high[v] = values[v] > high[v] ? values[v] : high[v];
      // Not of NaN, nor of infinite ones.
      finite &= values[v] - values[v] == Four{};
    }
  }
  FloatBox box;
  glm::vec3 lows[4], highs[4];
  std::memcpy(lows, low, sizeof(low));
  std::memcpy(highs, high, sizeof(high));
  for (int k = 0; k < 4; ++k) {
    box.minimum = glm::min(box.minimum, lows[k]);
    box.maximum = glm::max(box.maximum, highs[k]);
    box.is_finite = box.is_finite && finite[k] != 0;
  }
  for (std::size_t i = fours; i < points.size(); ++i) {
    box.minimum = glm::min(box.minimum, points[i]);
    box.maximum = glm::max(box.maximum, points[i]);
    for (int d = 0; d < 3; ++d) box.is_finite = box.is_finite && std::isfinite(points[i][d]);
  }
  return box;
}

/// Whether all lengths are within a tolerance of 1. A few that are may not count, so that no roots
/// are taken.
[[nodiscard]] inline bool are_surely_units(std::span<const glm::vec3> vectors, float tolerance) {
  const float most = 1.8f * tolerance;  // of a square: a little less than twice
  bool all = true;
  for (const glm::vec3& v : vectors) all &= std::abs(glm::dot(v, v) - 1.0f) <= most;
  return all;
}

}  // namespace planish
