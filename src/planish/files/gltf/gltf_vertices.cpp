#include "planish/files/gltf/gltf_vertices.h"

#include <unordered_map>

namespace planish {
namespace {

void split_seams(const SurfaceMesh& surface, GltfVertices& vertices) {
  const std::size_t own = surface.positions.size();
  vertices.uvs.assign(own, -1);
  vertices.corners.resize(surface.face_vertices.size());
  std::unordered_map<std::uint64_t, std::int32_t> copies;  // by row and texture coordinate
  for (std::size_t corner = 0; corner < surface.face_vertices.size(); ++corner) {
    const std::int32_t row = surface.face_vertices[corner];
    const std::int32_t uv = surface.face_uvs[corner];
    std::int32_t& vertex = vertices.corners[corner];
    vertex = row;
    if (vertices.uvs[row] < 0) vertices.uvs[row] = uv;
    if (vertices.uvs[row] == uv) continue;
    const std::uint64_t key =
        static_cast<std::uint64_t>(row) << 32 | static_cast<std::uint32_t>(uv);
    const auto next = static_cast<std::int32_t>(own + vertices.rows.size());
    const auto [entry, is_new] = copies.try_emplace(key, next);
    vertex = entry->second;
    if (!is_new) continue;
    vertices.rows.push_back(row);
    vertices.uvs.push_back(uv);
  }
}

void sort_by_group(const SurfaceMesh& surface, GltfVertices& vertices) {
  std::vector<GltfPart> all(surface.groups.size());
  for (std::size_t face = 0; face < surface.face_groups.size(); ++face) {
    GltfPart& part = all[surface.face_groups[face]];
    ++part.face_count;
    part.triangle_count += surface.face(static_cast<std::int64_t>(face)).size() - 2;
  }
  std::vector<std::size_t> next(all.size());
  std::size_t first = 0;
  for (std::size_t group = 0; group < all.size(); ++group) {
    next[group] = first;
    first += all[group].face_count;
    all[group].group = static_cast<std::int32_t>(group);
    if (all[group].face_count > 0) vertices.parts.push_back(all[group]);
  }
  if (vertices.parts.size() < 2) return;
  vertices.face_order.resize(surface.face_groups.size());
  for (std::size_t face = 0; face < surface.face_groups.size(); ++face)
    vertices.face_order[next[surface.face_groups[face]]++] = static_cast<std::int32_t>(face);
}

}  // namespace

GltfVertices gltf_vertices(const SurfaceMesh& surface) {
  GltfVertices vertices;
  if (!surface.face_uvs.empty()) split_seams(surface, vertices);
  if (!surface.face_groups.empty()) {
    sort_by_group(surface, vertices);
  } else {
    const auto faces = static_cast<std::uint64_t>(surface.face_count());
    vertices.parts = {{.group = -1,
                       .face_count = faces,
                       .triangle_count = surface.face_vertices.size() - 2 * faces}};
  }
  return vertices;
}

}  // namespace planish
