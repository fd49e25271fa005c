#include "planish/surface/folded_area.h"

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "planish/core/assert.h"
#include "planish/mesh/area_vector.h"
#include "planish/surface/attributes.h"

namespace planish {

double folded_area(const SurfaceMesh& surface, const PolygonMesh& input) {
  double folded = 0, whole = 0;
  std::vector<bool> is_hole(static_cast<std::size_t>(input.face_count()), false);
  for (const std::int32_t f : input.hole_faces) is_hole[f] = true;
  std::int64_t next = 0;
  for (std::int32_t f = 0; f < input.face_count(); ++f) {
    const glm::dvec3 input_normal = area_vector(input.positions, input.face(f));
    if (is_hole[f]) continue;
    // Descendants of a face follow one another.
    const std::int64_t count = descendant_count(input.face_size(f), surface.level);
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
