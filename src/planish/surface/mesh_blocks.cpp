#include "planish/surface/mesh_blocks.h"

#include <algorithm>

#include "planish/mesh/hole_flags.h"
#include "planish/surface/attributes.h"

namespace planish {

MeshBlocks::MeshBlocks(const SurfaceMesh& surface) : surface_(surface) {
  info_.level = surface.level;
  info_.row_count = static_cast<std::int64_t>(surface.positions.size());
  info_.face_count = surface.face_count();
  info_.corner_count = static_cast<std::int64_t>(surface.face_vertices.size());
  info_.uv_count = static_cast<std::int64_t>(surface.uvs.size());
  info_.has_colors = !surface.colors.empty();
  info_.has_groups = !surface.face_groups.empty();
  for (const VertexAttribute& attribute : surface.attributes)
    info_.attributes.push_back({attribute.name, attribute.width});
  info_.groups = surface.groups;
  info_.base_vertices = surface.base_vertices;
  info_.face_offsets = surface.face_offsets;
}

MeshBlocks::MeshBlocks(const SurfaceMesh& surface, const PolygonMesh& mesh) : MeshBlocks(surface) {
  const std::vector<std::uint8_t> is_hole = hole_flags(mesh);
  for (std::int32_t face = 0; face < mesh.face_count(); ++face) {
    if (is_hole[face]) continue;
    mesh_faces_.push_back(face);
    const std::int64_t last = ends_.empty() ? 0 : ends_.back();
    ends_.push_back(last + descendant_count(surface, mesh.face_size(face)));
  }
}

MeshBlocks::MeshBlocks(const SurfaceMesh& surface, std::span<const std::int32_t> mesh_faces)
    : MeshBlocks(surface) {
  given_faces_ = mesh_faces;
}

DegenerateRows MeshBlocks::rows(RowRange rows, const RowTarget& target) const {
  copy(surface_.positions, rows, target.positions);
  copy(surface_.normals, rows, target.normals);
  copy(surface_.colors, rows, target.colors);
  for (std::size_t i = 0; i < target.stored.size(); ++i) {
    target.stored[i] = glm::vec3(surface_.positions[rows.first + i] - target.origin);
  }
  return {};  // whoever made the surface has told
}

void MeshBlocks::attribute(std::size_t index, RowRange rows, std::span<float> values) const {
  const VertexAttribute& from = surface_.attributes[index];
  std::copy_n(from.values.begin() + from.width * rows.first, from.width * rows.count,
              values.begin());
}

void MeshBlocks::ancestors(RowRange faces, std::span<std::int32_t> mesh_faces) const {
  if (!given_faces_.empty()) return copy(given_faces_, faces, mesh_faces);
  auto at = std::upper_bound(ends_.begin(), ends_.end(), faces.first) - ends_.begin();
  for (std::int64_t i = 0; i < faces.count; ++i) {
    while (ends_[at] <= faces.first + i) ++at;
    mesh_faces[i] = mesh_faces_[at];
  }
}

void MeshBlocks::corners(RowRange faces, std::span<glm::dvec3> positions,
                         std::span<glm::vec3> normals) const {
  const RowRange range = corners_of(faces);
  for (std::int64_t i = 0; i < range.count; ++i) {
    const std::int32_t row = surface_.face_vertices[range.first + i];
    positions[i] = surface_.positions[row];
    normals[i] = surface_.normals[row];
  }
}

std::unique_ptr<SurfaceBlocks> blocks_of(const SurfaceMesh& surface, const PolygonMesh& mesh) {
  return std::make_unique<MeshBlocks>(surface, mesh);
}

}  // namespace planish
