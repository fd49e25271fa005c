#pragma once

#include <array>
#include <cmath>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <utility>

namespace planish {

/// A place of a square of this side as it is seen from the square's corner 0 to 3, counted
/// counter-clockwise, with the first axis along the side that leads on from it. Back again: by
/// (4 - corner) % 4. A vector: with side 0.
template <class Number>
[[nodiscard]] constexpr std::pair<Number, Number> seen_from(int corner, Number side, Number a,
                                                            Number b) {
  switch (corner) {
    case 0:
      return {a, b};
    case 1:
      return {b, side - a};
    case 2:
      return {side - a, side - b};
    default:
      return {side - b, a};
  }
}

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

struct PatchForm;

/// Nine Bezier points of a piece of a patch, (i, j) at i + 3 j, i along u.
using BezierNet = std::array<glm::dvec3, 9>;

/// Of a patch that is one polynomial.
[[nodiscard]] BezierNet bezier_net(const PatchForm& form, std::span<const glm::dvec3> points);

/// A quarter, not turned.
[[nodiscard]] BezierNet net_quarter(BezierNet net, bool upper_u, bool upper_v);

/// The net of the same piece as a patch sees it that is turned against it by so many quarters.
[[nodiscard]] BezierNet turned_net(const BezierNet& net, int turns);

/// The blossom of a quadratic by its Bezier points: at (t, t) its point at t.
[[nodiscard]] inline glm::dvec3 quadratic_blossom(const glm::dvec3& a, const glm::dvec3& b,
                                                  const glm::dvec3& c, double s, double t) {
  return (1 - t) * ((1 - s) * a + s * b) + t * ((1 - s) * b + s * c);
}

/// The part between two places along u or v, of 0 to 1.
[[nodiscard]] BezierNet net_between(const BezierNet& net, bool along_v, double from, double to);

}  // namespace planish
