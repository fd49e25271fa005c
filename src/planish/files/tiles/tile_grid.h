#pragma once

#include <algorithm>
#include <cmath>
#include <glm/vec3.hpp>
#include <limits>

namespace planish {

/// The grid that all positions of a tile set lie on: multiples of a power of two, so that their
/// differences to a tile's origin are float32 numbers without rounding, and two tiles have the same
/// place for the same point.
class TileGrid {
 public:
  /// Float32's.
  static constexpr int kFloatBits = 24;

  /// Positions may be `reach` away from their tile's origin and `largest` from the model's. The
  /// step is no finer than needed for numbers of `bits` and a sign, nor than `coarsest` / 2, where
  /// that is larger.
  TileGrid(double reach, double largest, int bits = kFloatBits, double coarsest = 0)
      : bits_(bits),
        step_(std::ldexp(1.0, std::max({exponent_of(reach) + 1 - bits, coarsest_exponent(coarsest),
                                        exponent_of(largest) + 1 - kDoubleBits}))) {}

  [[nodiscard]] double step() const { return step_; }
  /// As far from a tile's origin as such numbers hold all multiples.
  [[nodiscard]] double reach() const { return std::ldexp(step_, bits_) - step_; }
  [[nodiscard]] glm::dvec3 snap(const glm::dvec3& position) const {
    return {snap(position.x), snap(position.y), snap(position.z)};
  }

 private:
  static constexpr int kDoubleBits = 53;
  static constexpr double kSmallest = 1e-30;  // of a model of no size; floats end at 1e-38

  [[nodiscard]] static int exponent_of(double length) {
    return std::ilogb(std::max(length, kSmallest));
  }

  // Division and product by a power of two are exact.
  [[nodiscard]] double snap(double value) const { return std::nearbyint(value / step_) * step_; }

  [[nodiscard]] static int coarsest_exponent(double coarsest) {
    return coarsest > 0 ? std::ilogb(coarsest) : std::numeric_limits<int>::min();
  }

  int bits_;
  double step_;
};

}  // namespace planish
