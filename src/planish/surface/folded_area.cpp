#include "planish/surface/folded_area.h"

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "planish/core/assert.h"

namespace planish {

namespace {

template <class Vertices>
glm::dvec3 area_vector(const std::vector<glm::dvec3>& positions, const Vertices& vertices) {
  glm::dvec3 area(0.0);
  for (std::size_t i = 1; i + 1 < vertices.size(); ++i) {
    area += 0.5 * glm::cross(positions[vertices[i]] - positions[vertices[0]],
                             positions[vertices[i + 1]] - positions[vertices[0]]);
  }
  return area;
}

}  // namespace

double folded_area(const SurfaceMesh& surface, const PolygonMesh& input) {
  double folded = 0, whole = 0;
  std::int64_t next = 0;
  for (std::int32_t f = 0; f < input.face_count(); ++f) {
    const glm::dvec3 input_normal = area_vector(input.positions, input.face(f));
    // Descendants of a face follow one another: m on level 1, four times as many on each further.
    std::int64_t count = 1;
    if (surface.level > 0) {
      count = static_cast<std::int64_t>(input.face_size(f)) << (2 * (surface.level - 1));
    }
    for (const std::int64_t end = next + count; next < end; ++next) {
      const auto vertices = surface.face(next);
      const double share = glm::length(area_vector(surface.positions, vertices)) /
                           static_cast<double>(vertices.size());
      for (const std::int32_t v : vertices) {
        whole += share;
        if (glm::dot(glm::dvec3(surface.normals[v]), input_normal) < 0) folded += share;
      }
    }
  }
  PLANISH_ASSERT(next == surface.face_count());
  return whole > 0 ? folded / whole : 0.0;
}

}  // namespace planish
