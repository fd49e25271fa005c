#include "planish/mesh/placement.h"

#include <cmath>
#include <glm/common.hpp>
#include <limits>

namespace planish {

Placement placement_of(const PolygonMesh& mesh) {
  if (mesh.face_vertices.empty()) return {};
  glm::dvec3 low(std::numeric_limits<double>::max());
  glm::dvec3 high(std::numeric_limits<double>::lowest());
  for (const std::int32_t vertex : mesh.face_vertices) {
    low = glm::min(low, mesh.positions[vertex]);
    high = glm::max(high, mesh.positions[vertex]);
  }
  const glm::dvec3 extent = high - low;
  // hypot neither overflows nor underflows on the way, as the root of a sum of squares would.
  const double diagonal = std::hypot(extent.x, extent.y, extent.z);
  return {.centre = 0.5 * low + 0.5 * high, .diagonal = diagonal > 0 ? diagonal : 1.0};
}

}  // namespace planish
