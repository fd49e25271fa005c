#pragma once

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace planish {

/// 0 where the vector has no length.
[[nodiscard]] inline glm::dvec3 unit_or_zero(const glm::dvec3& vector) {
  const double length = glm::length(vector);
  return length > 0 ? vector / length : glm::dvec3(0.0);
}

}  // namespace planish
