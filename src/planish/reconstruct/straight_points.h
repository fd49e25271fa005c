#pragma once

#include <algorithm>
#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace planish {

/// How far points, of which there must be some, lie at most from the line through two of them that
/// are far apart. `Points` has size() and places by index.
template <class Points>
double distance_from_line(const Points& points) {
  const auto farthest_from = [&](const glm::dvec3& place) {
    glm::dvec3 farthest = place;
    double most = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const glm::dvec3 point = points[i];
      const glm::dvec3 off = point - place;
      if (glm::dot(off, off) <= most) continue;
      most = glm::dot(off, off);
      farthest = point;
    }
    return farthest;
  };
  const glm::dvec3 from = farthest_from(points[0]), along = farthest_from(from) - from;
  const double length = glm::length(along);
  if (!(length > 0)) return 0;
  double most = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    most = std::max(most, glm::length(glm::cross(along, points[i] - from)));
  return most / length;
}

}  // namespace planish
