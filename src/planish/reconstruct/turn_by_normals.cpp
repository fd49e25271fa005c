#include "planish/reconstruct/turn_by_normals.h"

#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <utility>
#include <vector>

#include "planish/mesh/triangle_edges.h"

namespace planish {
namespace {

// 1 for a triangle along the normals of its corners, -1 for one against them, 0 where they are
// silent.
int agreement(std::span<const glm::dvec3> positions, std::span<const glm::vec3> normals,
              const Triangle& triangle) {
  const glm::dvec3 &a = positions[triangle[0]], &b = positions[triangle[1]],
                   &c = positions[triangle[2]];
  const glm::dvec3 facing = glm::cross(b - a, c - a);
  double sum = 0;
  for (const std::int32_t corner : triangle) {
    const glm::dvec3 normal = normals[corner];
    const double length = glm::length(normal);
    if (length > 0 && std::isfinite(length)) sum += glm::dot(facing, normal) / length;
  }
  return sum > 0 ? 1 : sum < 0 ? -1 : 0;
}

}  // namespace

std::int64_t turn_by_normals(std::span<const glm::dvec3> positions,
                             std::span<const glm::vec3> normals, std::span<Triangle> triangles) {
  const std::vector<std::int32_t> twins = twins_of(triangles, positions.size());
  std::vector<bool> reached(triangles.size(), false);
  std::vector<std::int32_t> component;
  std::int64_t turned_count = 0;
  for (std::size_t start = 0; start < triangles.size(); ++start) {
    if (reached[start]) continue;
    reached[start] = true;
    component.assign(1, static_cast<std::int32_t>(start));
    bool is_open = false;
    std::int64_t votes = 0;
    for (std::size_t i = 0; i < component.size(); ++i) {
      const std::int32_t t = component[i];
      votes += agreement(positions, normals, triangles[t]);
      for (std::int32_t half_edge = 3 * t; half_edge < 3 * t + 3; ++half_edge) {
        const std::int32_t twin = twins[half_edge];
        if (twin < 0) is_open = true;
        if (twin < 0 || reached[twin / 3]) continue;
        reached[twin / 3] = true;
        component.push_back(twin / 3);
      }
    }
    if (!is_open || votes >= 0) continue;
    for (const std::int32_t t : component) std::swap(triangles[t][1], triangles[t][2]);
    ++turned_count;
  }
  return turned_count;
}

}  // namespace planish
