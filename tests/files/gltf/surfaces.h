#pragma once

#include <cmath>
#include <cstdint>
#include <glm/vec2.hpp>
#include <vector>

#include "planish/surface/surface_blocks.h"

namespace planish::test {

/// A wavy open grid of `columns` x `rows` vertices at level 1, its exact normals, about `centre`.
inline SurfaceMesh wavy_grid(std::int32_t columns, std::int32_t rows,
                             const glm::dvec3& centre = glm::dvec3(0)) {
  SurfaceMesh surface;
  surface.level = 1;
  for (std::int32_t j = 0; j < rows; ++j) {
    for (std::int32_t i = 0; i < columns; ++i) {
      const double u = i * 0.1, v = j * 0.07;
      surface.positions.push_back(centre + glm::dvec3(u, v, 0.3 * std::sin(u) * std::cos(v)));
      const glm::dvec3 normal(-0.3 * std::cos(u) * std::cos(v), 0.3 * std::sin(u) * std::sin(v), 1);
      const double length =
          std::sqrt(normal.x * normal.x + normal.y * normal.y + normal.z * normal.z);
      surface.normals.push_back(glm::vec3(normal / length));
    }
  }
  for (std::int32_t j = 0; j + 1 < rows; ++j) {
    for (std::int32_t i = 0; i + 1 < columns; ++i) {
      const std::int32_t a = j * columns + i;
      surface.face_vertices.insert(surface.face_vertices.end(),
                                   {a, a + 1, a + 1 + columns, a + columns});
    }
  }
  return surface;
}

/// One level-0 face in the plane z = 0 for each polygon.
inline SurfaceMesh flat_polygons(const std::vector<std::vector<glm::dvec2>>& polygons) {
  SurfaceMesh surface;
  surface.face_offsets = {0};
  for (const auto& polygon : polygons) {
    for (const glm::dvec2& point : polygon) {
      surface.face_vertices.push_back(static_cast<std::int32_t>(surface.positions.size()));
      surface.positions.emplace_back(point.x, point.y, 0.0);
      surface.normals.emplace_back(0.0f, 0.0f, 1.0f);
    }
    surface.face_offsets.push_back(static_cast<std::int32_t>(surface.face_vertices.size()));
  }
  return surface;
}

/// A flat grid of 4 x 2 quads: the left half and the right half are a chart (u = x, u = x + 10;
/// v = y) and a group each, with a seam of three vertices on x = 0.5.
inline SurfaceMesh two_charts() {
  SurfaceMesh surface;
  surface.level = 1;
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 5; ++i) {
      surface.positions.emplace_back(0.25 * i, 0.5 * j, 0.0);
      surface.normals.emplace_back(0.0f, 0.0f, 1.0f);
    }
  }
  for (const int chart : {0, 1})
    for (const glm::dvec3& p : surface.positions) surface.uvs.emplace_back(p.x + 10 * chart, p.y);
  for (std::int32_t j = 0; j < 2; ++j) {
    for (std::int32_t i = 0; i < 4; ++i) {
      const std::int32_t a = 5 * j + i;
      for (const std::int32_t v : {a, a + 1, a + 6, a + 5}) {
        surface.face_vertices.push_back(v);
        surface.face_uvs.push_back(i < 2 ? v : v + 15);
      }
      surface.face_groups.push_back(i < 2 ? 0 : 1);
    }
  }
  surface.groups = {{"left", "red"}, {"right", "blue"}};
  return surface;
}

}  // namespace planish::test
