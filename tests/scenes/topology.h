#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <map>
#include <numbers>
#include <set>
#include <utility>

#include "planish/mesh/polygon_mesh.h"

namespace planish::shapes {

/// Counts made from directed edges alone, independent of the library's own check().
struct Topology {
  std::int64_t vertex_count = 0;  ///< vertices that faces name
  std::int64_t face_count = 0;
  std::int64_t edge_count = 0;
  std::int64_t border_edge_count = 0;
  std::int64_t doubled_edge_count = 0;  ///< directed edges of more than one face
  [[nodiscard]] std::int64_t euler_characteristic() const {
    return vertex_count - edge_count + face_count;
  }
};

inline Topology topology_of(const PolygonMesh& mesh) {
  Topology result;
  std::map<std::pair<std::int32_t, std::int32_t>, int> directed;
  std::set<std::int32_t> used;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto corners = mesh.face(f);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      used.insert(corners[i]);
      if (++directed[{corners[i], corners[(i + 1) % corners.size()]}] == 2) {
        ++result.doubled_edge_count;
      }
    }
  }
  for (const auto& [edge, count] : directed) {
    if (!directed.contains({edge.second, edge.first})) ++result.border_edge_count;
  }
  result.vertex_count = static_cast<std::int64_t>(used.size());
  result.face_count = mesh.face_count();
  result.edge_count = (static_cast<std::int64_t>(directed.size()) + result.border_edge_count) / 2;
  return result;
}

/// Volume by the divergence theorem; positive when a closed mesh faces outward.
inline double volume_of(const PolygonMesh& mesh) {
  double volume = 0.0;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto corners = mesh.face(f);
    for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
      const glm::dvec3& a = mesh.positions[corners[0]];
      const glm::dvec3& b = mesh.positions[corners[i]];
      const glm::dvec3& c = mesh.positions[corners[i + 1]];
      volume += glm::dot(a, glm::cross(b, c)) / 6.0;
    }
  }
  return volume;
}

/// Smallest and largest interior angle in degrees, about the Newell normal; above 180 where
/// concave.
inline std::pair<double, double> corner_angles(const PolygonMesh& mesh) {
  double least = 360.0;
  double greatest = 0.0;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto corners = mesh.face(f);
    const std::size_t size = corners.size();
    glm::dvec3 normal(0.0);
    for (std::size_t i = 0; i < size; ++i) {
      normal += glm::cross(mesh.positions[corners[i]] - mesh.positions[corners[0]],
                           mesh.positions[corners[(i + 1) % size]] - mesh.positions[corners[0]]);
    }
    normal = glm::normalize(normal);
    for (std::size_t i = 0; i < size; ++i) {
      const glm::dvec3& here = mesh.positions[corners[i]];
      const glm::dvec3 next = mesh.positions[corners[(i + 1) % size]] - here;
      const glm::dvec3 previous = mesh.positions[corners[(i + size - 1) % size]] - here;
      double angle =
          std::atan2(glm::dot(glm::cross(next, previous), normal), glm::dot(next, previous)) *
          180.0 / std::numbers::pi;
      if (angle < 0.0) angle += 360.0;
      least = std::min(least, angle);
      greatest = std::max(greatest, angle);
    }
  }
  return {least, greatest};
}

}  // namespace planish::shapes
