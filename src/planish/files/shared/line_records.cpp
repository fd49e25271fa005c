#include "planish/files/shared/line_records.h"

#include <limits>

namespace planish {

bool FaceParts::append_to(PolygonMesh& mesh) const {
  std::size_t face_count = mesh.face_offsets.size(), corner_count = mesh.face_vertices.size();
  for (const Part& part : parts) {
    face_count += part.sizes.size();
    corner_count += part.vertices.size();
  }
  if (corner_count >= static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
    return false;
  mesh.face_offsets.reserve(face_count);
  mesh.face_vertices.reserve(corner_count);
  for (const Part& part : parts) {
    for (const std::int32_t size : part.sizes)
      mesh.face_offsets.push_back(mesh.face_offsets.back() + size);
    mesh.face_vertices.insert(mesh.face_vertices.end(), part.vertices.begin(), part.vertices.end());
  }
  return true;
}

}  // namespace planish
