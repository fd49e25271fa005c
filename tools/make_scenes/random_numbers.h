#pragma once

#include <cstdint>
#include <random>

namespace planish::shapes {

/// Random numbers that are the same with every standard library (its distributions are not).
class RandomNumbers {
 public:
  explicit RandomNumbers(std::uint32_t seed) : engine_(seed) {}

  /// Even in [0, 1).
  double unit() { return engine_() * 0x1p-32; }
  /// Even in [-1, 1).
  double sway() { return 2 * unit() - 1; }
  /// Even in [0, count), count >= 1.
  std::int32_t below(std::int32_t count) { return static_cast<std::int32_t>(unit() * count); }

 private:
  std::mt19937 engine_;
};

}  // namespace planish::shapes
