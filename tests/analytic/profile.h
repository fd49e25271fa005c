#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <numbers>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish::test {

// A profile of lines and arcs, (distance from the axis, height), from below to above.
class Profile {
 public:
  explicit Profile(const glm::dvec2& start) : points_{start} {}
  Profile& line(const glm::dvec2& to) {
    points_.push_back(to);
    return *this;
  }
  Profile& arc(const glm::dvec2& centre, double radius, double from, double to, int steps) {
    for (int i = 1; i <= steps; ++i) {
      const double angle = from + (to - from) * i / steps;
      points_.push_back(centre + radius * glm::dvec2(std::cos(angle), std::sin(angle)));
    }
    return *this;
  }
  // Turned about z: quads, or triangles at the axis.
  [[nodiscard]] PolygonMesh turned(int steps) const {
    PolygonMesh mesh;
    std::vector<std::vector<std::int32_t>> rings;
    for (const glm::dvec2& p : points_) {
      auto& ring = rings.emplace_back();
      const int count = p.x < 1e-12 ? 1 : steps;
      for (int i = 0; i < count; ++i) {
        const double angle = 2 * std::numbers::pi * i / steps;
        ring.push_back(mesh.vertex_count());
        mesh.positions.emplace_back(p.x * std::cos(angle), p.x * std::sin(angle), p.y);
      }
    }
    const auto at = [](const std::vector<std::int32_t>& ring, int i) {
      return ring[static_cast<std::size_t>(i) % ring.size()];
    };
    for (std::size_t r = 0; r + 1 < rings.size(); ++r) {
      for (int i = 0; i < steps; ++i) {
        std::vector<std::int32_t> face{at(rings[r], i), at(rings[r], i + 1),
                                       at(rings[r + 1], i + 1), at(rings[r + 1], i)};
        face.erase(std::unique(face.begin(), face.end()), face.end());
        if (face.front() == face.back()) face.pop_back();
        mesh.add_face(face);
      }
    }
    return mesh;
  }

 private:
  std::vector<glm::dvec2> points_;
};

// Turned about no axis of the coordinates, scaled by kPoseScale and moved.
inline constexpr double kPoseScale = 25.4;
inline PolygonMesh posed(PolygonMesh mesh) {
  const glm::dvec3 axis = glm::normalize(glm::dvec3(1, 2, -0.7));
  for (glm::dvec3& p : mesh.positions)
    p = glm::dvec3(7, -3, 11) +
        kPoseScale * (std::cos(1.1) * p + std::sin(1.1) * glm::cross(axis, p) +
                      (1 - std::cos(1.1)) * glm::dot(axis, p) * axis);
  return mesh;
}

// Both bodies, the second one this far along x.
inline PolygonMesh beside(PolygonMesh mesh, const PolygonMesh& other, double x) {
  const std::int32_t first = mesh.vertex_count();
  for (const glm::dvec3& p : other.positions) mesh.positions.push_back(glm::dvec3(x, 0, 0) + p);
  for (std::int32_t f = 0; f < other.face_count(); ++f) {
    std::vector<std::int32_t> face;
    for (const std::int32_t v : other.face(f)) face.push_back(first + v);
    mesh.add_face(face);
  }
  return mesh;
}

}  // namespace planish::test
