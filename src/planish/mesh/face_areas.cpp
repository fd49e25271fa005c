#include "planish/mesh/face_areas.h"

#include "planish/core/parallel.h"
#include "planish/mesh/area_vector.h"

namespace planish {

std::vector<glm::dvec3> face_areas(const PolygonMesh& mesh) {
  std::vector<glm::dvec3> areas(static_cast<std::size_t>(mesh.face_count()));
  parallel_each(areas.size(),
                [&](std::int32_t f) { areas[f] = area_vector(mesh.positions, mesh.face(f)); });
  return areas;
}

}  // namespace planish
