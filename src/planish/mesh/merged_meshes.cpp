#include "planish/mesh/merged_meshes.h"

#include <algorithm>
#include <optional>
#include <string>

#include "planish/core/error.h"
#include "planish/mesh/mesh_arrays.h"

namespace planish {

namespace {

void check_sizes(std::span<const PolygonMesh> meshes, std::int32_t most) {
  std::size_t vertices = 0, corners = 0, faces = 0, uvs = 0;
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    vertices += meshes[i].positions.size();
    corners += meshes[i].face_vertices.size();
    faces += arrays_of(meshes[i]).face_count();
    uvs += meshes[i].uvs.size();
    const std::size_t largest = std::max({vertices, corners, faces, uvs});
    if (largest > static_cast<std::size_t>(most))
      throw Error(ErrorCode::UnusableMesh,
                  formatted("mesh {} would make {} vertices, corners, faces or uvs of one mesh, "
                            "more than the {} that it may have; merge fewer meshes",
                            i, largest, most),
                  static_cast<std::int64_t>(i));
  }
}

void check_indices(std::span<const PolygonMesh> meshes) {
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    const std::optional<MeshProblem> problem = first_index_problem(arrays_of(meshes[i]));
    if (problem)
      throw Error(ErrorCode::UnusableMesh, formatted("mesh {}: {}", i, problem->message),
                  static_cast<std::int64_t>(i));
  }
}

void append_shifted(std::vector<std::int32_t>& to, const std::vector<std::int32_t>& from,
                    std::int32_t shift) {
  for (const std::int32_t index : from) to.push_back(index < 0 ? index : index + shift);
}

// What some have, filled up for those without.
struct Wanted {
  bool uvs = false, colors = false, groups = false;
};

void append_extras(PolygonMesh& all, const PolygonMesh& mesh, const Wanted& wanted) {
  if (wanted.uvs) {
    const auto first = static_cast<std::int32_t>(all.uvs.size());
    all.uvs.insert(all.uvs.end(), mesh.uvs.begin(), mesh.uvs.end());
    append_shifted(all.face_uvs, mesh.face_uvs, first);
    all.face_uvs.resize(all.face_vertices.size(), -1);
  }
  if (wanted.colors) {
    all.colors.insert(all.colors.end(), mesh.colors.begin(), mesh.colors.end());
    all.colors.resize(all.positions.size(), glm::vec4(1));
  }
  if (!wanted.groups) return;
  const auto first = static_cast<std::int32_t>(all.groups.size());
  all.groups.insert(all.groups.end(), mesh.groups.begin(), mesh.groups.end());
  append_shifted(all.face_groups, mesh.face_groups, first);
  const auto face_count = static_cast<std::size_t>(all.face_count());
  if (all.face_groups.size() == face_count) return;
  all.groups.emplace_back();
  all.face_groups.resize(face_count, static_cast<std::int32_t>(all.groups.size()) - 1);
}

void append(PolygonMesh& all, const PolygonMesh& mesh, const Wanted& wanted) {
  const std::int32_t first_vertex = all.vertex_count(), first_face = all.face_count();
  const auto first_corner = static_cast<std::int32_t>(all.face_vertices.size());
  all.positions.insert(all.positions.end(), mesh.positions.begin(), mesh.positions.end());
  append_shifted(all.face_vertices, mesh.face_vertices, first_vertex);
  for (std::size_t f = 1; f < mesh.face_offsets.size(); ++f)
    all.face_offsets.push_back(first_corner + mesh.face_offsets[f]);
  for (const CreaseEdge& edge : mesh.creases)
    all.creases.push_back({edge.v0 + first_vertex, edge.v1 + first_vertex, edge.sharpness});
  for (const CornerVertex& corner : mesh.corners)
    all.corners.push_back({corner.vertex + first_vertex, corner.sharpness});
  append_shifted(all.hole_faces, mesh.hole_faces, first_face);
  append_extras(all, mesh, wanted);
}

}  // namespace

MergedMeshes merged_meshes(std::span<const PolygonMesh> meshes, std::int32_t most) {
  check_sizes(meshes, most);
  check_indices(meshes);
  Wanted wanted;
  for (const PolygonMesh& mesh : meshes) {
    wanted.uvs |= !mesh.face_uvs.empty();
    wanted.colors |= !mesh.colors.empty();
    wanted.groups |= !mesh.face_groups.empty();
  }
  MergedMeshes merged;
  for (const PolygonMesh& mesh : meshes) {
    merged.first_vertices.push_back(merged.mesh.vertex_count());
    merged.first_faces.push_back(merged.mesh.face_count());
    append(merged.mesh, mesh, wanted);
  }
  merged.first_vertices.push_back(merged.mesh.vertex_count());
  merged.first_faces.push_back(merged.mesh.face_count());
  return merged;
}

}  // namespace planish
