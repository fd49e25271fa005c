#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace planish {

/// In radians, 0 to pi, of vectors of any length; 0 where one has none.
[[nodiscard]] inline double angle_between(const glm::dvec3& a, const glm::dvec3& b) {
  if (glm::length(a) == 0 || glm::length(b) == 0) return 0;
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

}  // namespace planish
