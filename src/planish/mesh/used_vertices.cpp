#include "planish/mesh/used_vertices.h"

namespace planish {

UsedMesh without_unused_vertices(const PolygonMesh& mesh) {
  std::vector<std::int32_t> new_index(mesh.positions.size(), -1);
  for (const std::int32_t v : mesh.face_vertices) new_index[v] = 0;
  UsedMesh used;
  for (std::size_t v = 0; v < new_index.size(); ++v) {
    if (new_index[v] < 0) continue;
    new_index[v] = static_cast<std::int32_t>(used.vertices.size());
    used.vertices.push_back(static_cast<std::int32_t>(v));
  }
  if (used.vertices.size() == mesh.positions.size()) {
    used.mesh = mesh;
    return used;
  }
  used.mesh.face_offsets = mesh.face_offsets;
  used.mesh.uvs = mesh.uvs;
  used.mesh.face_uvs = mesh.face_uvs;
  used.mesh.groups = mesh.groups;
  used.mesh.face_groups = mesh.face_groups;
  used.mesh.hole_faces = mesh.hole_faces;
  used.mesh.positions.reserve(used.vertices.size());
  used.mesh.colors.reserve(mesh.colors.empty() ? 0 : used.vertices.size());
  for (const std::int32_t v : used.vertices) {
    used.mesh.positions.push_back(mesh.positions[v]);
    if (!mesh.colors.empty()) used.mesh.colors.push_back(mesh.colors[v]);
  }
  used.mesh.face_vertices.reserve(mesh.face_vertices.size());
  for (const std::int32_t v : mesh.face_vertices) used.mesh.face_vertices.push_back(new_index[v]);
  for (const CreaseEdge& crease : mesh.creases) {
    used.mesh.creases.push_back({new_index[crease.v0], new_index[crease.v1], crease.sharpness});
  }
  for (const CornerVertex& corner : mesh.corners) {
    if (new_index[corner.vertex] >= 0) {
      used.mesh.corners.push_back({new_index[corner.vertex], corner.sharpness});
    }
  }
  return used;
}

}  // namespace planish
