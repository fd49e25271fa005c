#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <span>

namespace planish {

/// The vector area of a polygon: along its Newell normal, as long as the area it encloses where it
/// is flat. Any number of corners; zero for fewer than three.
[[nodiscard]] inline glm::dvec3 area_vector(std::span<const glm::dvec3> positions,
                                            std::span<const std::int32_t> vertices) {
  glm::dvec3 area(0.0);
  for (std::size_t i = 1; i + 1 < vertices.size(); ++i) {
    area += 0.5 * glm::cross(positions[vertices[i]] - positions[vertices[0]],
                             positions[vertices[i + 1]] - positions[vertices[0]]);
  }
  return area;
}

}  // namespace planish
