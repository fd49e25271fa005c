#pragma once

#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>

namespace planish {

/// A unit vector in 4 bytes, to 0.01 degrees; or none.
/// Source: Z. Cigolle et al., "A Survey of Efficient Representations for Independent Unit Vectors",
/// 2014 (the octahedral map).
class PackedNormal {
 public:
  PackedNormal() = default;
  /// Of any length; none where that is 0.
  explicit PackedNormal(const glm::dvec3& v) {
    const double sum = std::abs(v.x) + std::abs(v.y) + std::abs(v.z);
    if (!(sum > 0)) return;
    double x = v.x / sum, y = v.y / sum;
    if (v.z < 0) {
      const double folded = std::copysign(1 - std::abs(y), x);
      y = std::copysign(1 - std::abs(x), y);
      x = folded;
    }
    x_ = static_cast<std::int16_t>(std::lround(kScale * x));
    y_ = static_cast<std::int16_t>(std::lround(kScale * y));
  }
  /// Unit, or 0 for none.
  [[nodiscard]] glm::vec3 get() const {
    if (x_ == kNone) return glm::vec3(0.0f);
    double x = x_ / kScale, y = y_ / kScale;
    const double z = 1 - std::abs(x) - std::abs(y);
    if (z < 0) {
      const double folded = std::copysign(1 - std::abs(y), x);
      y = std::copysign(1 - std::abs(x), y);
      x = folded;
    }
    return glm::vec3(glm::dvec3(x, y, z) / std::sqrt(x * x + y * y + z * z));
  }

 private:
  static constexpr double kScale = 32767;
  static constexpr std::int16_t kNone = -32768;
  std::int16_t x_ = kNone, y_ = 0;
};

}  // namespace planish
