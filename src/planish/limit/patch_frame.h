#pragma once

#include <cmath>
#include <glm/vec2.hpp>

#include "planish/patches/quarter_turn.h"

namespace planish {

/// Where a square that quarters within quarters lead to lies in its patch: its own (u, v) are
/// turned by quarter turns, shrunk and moved. All exact.
struct PatchFrame {
  double u = 0, v = 0, size = 1;
  int c = 1, s = 0;

  [[nodiscard]] glm::dvec2 at(double own_u, double own_v) const {
    return {u + size * (c * own_u - s * own_v), v + size * (s * own_u + c * own_v)};
  }
  /// Quarter 0 to 3 of the square, as PatchForm has them: seen from its own corner.
  [[nodiscard]] PatchFrame quarter(int index) const {
    const int back = (4 - index) % 4;
    const auto [a, b] = seen_from(back, 1, 0, 0);
    const auto [turned_c, turned_s] = seen_from(back, 0, c, s);
    const glm::dvec2 corner = at(a, b);
    return {corner.x, corner.y, 0.5 * size, turned_c, turned_s};
  }
  /// A quarter, not turned.
  [[nodiscard]] PatchFrame half(bool upper_u, bool upper_v) const {
    const glm::dvec2 corner = at(upper_u ? 0.5 : 0, upper_v ? 0.5 : 0);
    return {corner.x, corner.y, 0.5 * size, c, s};
  }
  /// How often the patch's sides were halved.
  [[nodiscard]] int halvings() const { return -std::ilogb(size); }
};

}  // namespace planish
