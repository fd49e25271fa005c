#pragma once

#include <algorithm>
#include <cmath>
#include <glm/vec3.hpp>

namespace planish {

/// The grid that all positions of a tile set lie on: multiples of a power of two, so that their
/// differences to a tile's origin are float32 numbers without rounding, and two tiles have the same
/// place for the same point.
class TileGrid {
 public:
  /// Positions may be `reach` away from their tile's origin and `largest` from the model's.
  TileGrid(double reach, double largest)
      : exponent_(std::max(std::ilogb(std::max(reach, kSmallest)) + 1 - kFloatBits,
                           std::ilogb(std::max(largest, kSmallest)) + 1 - kDoubleBits)),
        step_(std::ldexp(1.0, exponent_)) {}

  [[nodiscard]] double step() const { return step_; }
  /// As far from a tile's origin as float32 holds all multiples.
  [[nodiscard]] double reach() const { return std::ldexp(step_, kFloatBits); }
  [[nodiscard]] glm::dvec3 snap(const glm::dvec3& position) const {
    return {snap(position.x), snap(position.y), snap(position.z)};
  }

 private:
  static constexpr int kFloatBits = 24, kDoubleBits = 53;
  static constexpr double kSmallest = 1e-30;  // of a model of no size; floats end at 1e-38

  // Division and product by a power of two are exact.
  [[nodiscard]] double snap(double value) const { return std::nearbyint(value / step_) * step_; }

  int exponent_;
  double step_;
};

}  // namespace planish
