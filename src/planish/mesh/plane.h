#pragma once

#include <glm/vec2.hpp>

namespace planish {

/// Twice the signed area of the triangle that a and b span: positive where b lies left of a.
[[nodiscard]] inline double cross(const glm::dvec2& a, const glm::dvec2& b) {
  return a.x * b.y - a.y * b.x;
}

/// Twice the signed area of a, b, c: positive where they turn left.
[[nodiscard]] inline double turn(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
  return cross(b - a, c - a);
}

}  // namespace planish
