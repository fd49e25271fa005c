#pragma once

#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "planish/fair/fair_topology.h"

namespace planish {

/// Along the limit normal at the centre of a polygon of control points, not normalised: t1 x t2 of
/// its first Fourier pair. `point(i)` for i in [0, count). Zero for fewer than three points.
template <class Point>
[[nodiscard]] glm::dvec3 limit_normal(const FairTopology& topology, std::int32_t count,
                                      const Point& point) {
  if (count < 3) return glm::dvec3(0.0);
  if (count == 3) return glm::cross(point(1) - point(0), point(2) - point(0));
  if (count == 4) return glm::cross(point(0) - point(2), point(1) - point(3));
  const auto circle = topology.unit_circle.of(count);
  const glm::dvec3 origin = point(0);
  glm::dvec3 tangent1(0.0), tangent2(0.0);
  for (std::int32_t i = 1; i < count; ++i) {
    const glm::dvec3 p = point(i) - origin;
    tangent1 += circle[i].x * p;
    tangent2 += circle[i].y * p;
  }
  return glm::cross(tangent1, tangent2);
}

}  // namespace planish
