#include "planish/job/least_step_faces.h"

#include <algorithm>

namespace planish {

std::int64_t least_step_faces(const PolygonMesh& mesh, const MeshTopology& topology,
                              std::int32_t face_size) {
  std::int64_t quads = topology.corner_count(), corners = 0;
  if (mesh.hole_faces.empty()) {
    for (std::int32_t v = 0; v < topology.vertex_count(); ++v) {
      const auto valence = std::ssize(topology.corners_at(v));
      if (valence != 4 && !topology.is_boundary_vertex(v)) corners += valence;
    }
    for (std::int32_t f = 0; f < topology.face_count(); ++f)
      if (topology.face_size(f) != 4) corners += topology.face_size(f);
  } else {
    quads = 0;  // hidden faces are left out
  }
  const std::int64_t largest = std::int64_t{face_size} * face_size;
  return std::max((corners + 3) / 4, (quads + largest - 1) / largest);
}

}  // namespace planish
