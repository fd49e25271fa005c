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
  used.mesh = mesh;
  used.mesh.positions.clear();
  used.mesh.colors.clear();
  used.mesh.creases.clear();
  used.mesh.corners.clear();
  for (const std::int32_t v : used.vertices) {
    used.mesh.positions.push_back(mesh.positions[v]);
    if (!mesh.colors.empty()) used.mesh.colors.push_back(mesh.colors[v]);
  }
  for (std::int32_t& v : used.mesh.face_vertices) v = new_index[v];
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
