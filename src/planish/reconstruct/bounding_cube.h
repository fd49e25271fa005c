#pragma once

#include <algorithm>
#include <glm/vec3.hpp>
#include <span>

#include "planish/core/point_bounds.h"

namespace planish {

struct BoundingCube {
  glm::dvec3 low;
  double side;  ///< the largest extent of the points
};

[[nodiscard]] inline double largest_extent(const glm::dvec3& low, const glm::dvec3& high) {
  const glm::dvec3 extent = high - low;
  return std::max({extent.x, extent.y, extent.z});
}

/// Of at least one point.
[[nodiscard]] inline BoundingCube bounding_cube(std::span<const glm::dvec3> points) {
  const auto [low, high] = point_bounds(points);
  return {low, largest_extent(low, high)};
}

}  // namespace planish
