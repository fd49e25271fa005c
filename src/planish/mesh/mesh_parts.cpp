#include "planish/mesh/mesh_parts.h"

#include <algorithm>
#include <tuple>

#include "planish/mesh/disjoint_sets.h"

namespace planish {

namespace {

// Adds those faces of `from` that are wanted, and the tags at their vertices.
template <class IsWanted>
void add_faces(PolygonMesh& to, const PolygonMesh& from, const IsWanted& is_wanted) {
  std::vector<std::uint8_t> is_used(from.positions.size(), 0);
  std::size_t hole = 0;
  std::vector<std::int32_t> holes = from.hole_faces;
  std::ranges::sort(holes);
  for (std::int32_t f = 0; f < from.face_count(); ++f) {
    while (hole < holes.size() && holes[hole] < f) ++hole;
    if (!is_wanted(f)) continue;
    if (hole < holes.size() && holes[hole] == f) to.hole_faces.push_back(to.face_count());
    for (const std::int32_t v : from.face(f)) is_used[v] = 1;
    to.add_face(from.face(f));
    if (!from.face_uvs.empty())
      to.face_uvs.insert(to.face_uvs.end(), from.face_uvs.begin() + from.face_offsets[f],
                         from.face_uvs.begin() + from.face_offsets[f + 1]);
    if (!from.face_groups.empty()) to.face_groups.push_back(from.face_groups[f]);
  }
  for (const CreaseEdge& crease : from.creases)
    if (is_used[crease.v0] != 0) to.creases.push_back(crease);
  for (const CornerVertex& corner : from.corners)
    if (is_used[corner.vertex] != 0) to.corners.push_back(corner);
}

// Vertices of faces at one place.
void unite_touching(const PolygonMesh& mesh, DisjointSets& sets) {
  const std::int32_t first = sets.find(mesh.face_vertices.empty() ? 0 : mesh.face_vertices[0]);
  const auto is_first = [&](std::int32_t v) { return sets.find(v) == first; };
  if (std::ranges::all_of(mesh.face_vertices, is_first)) return;  // one part, as mostly
  std::vector<std::int32_t> vertices = mesh.face_vertices;
  const auto key = [&](std::int32_t v) {
    const glm::dvec3& p = mesh.positions[v];
    return std::tuple(p.x, p.y, p.z, v);
  };
  std::ranges::sort(vertices, {}, key);
  for (std::size_t i = 1; i < vertices.size(); ++i)
    if (mesh.positions[vertices[i - 1]] == mesh.positions[vertices[i]])
      sets.unite(vertices[i - 1], vertices[i]);
}

}  // namespace

std::vector<std::int32_t> MeshParts::of_faces(const PolygonMesh& mesh) const {
  std::vector<std::int32_t> parts(static_cast<std::size_t>(mesh.face_count()));
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) parts[f] = of_vertex[mesh.face(f)[0]];
  return parts;
}

MeshParts mesh_parts(const PolygonMesh& mesh) {
  DisjointSets sets(mesh.positions.size());
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    for (const std::int32_t v : face) sets.unite(face[0], v);
  }
  unite_touching(mesh, sets);
  MeshParts parts;
  parts.of_vertex.assign(mesh.positions.size(), -1);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    std::int32_t& number = parts.of_vertex[sets.find(mesh.face(f)[0])];
    if (number < 0) number = parts.count++;
  }
  for (const std::int32_t v : mesh.face_vertices)
    parts.of_vertex[v] = parts.of_vertex[sets.find(v)];
  return parts;
}

std::vector<PolygonMesh> meshes_of(const MeshParts& parts, const PolygonMesh& mesh) {
  std::vector<PolygonMesh> meshes(static_cast<std::size_t>(parts.count));
  std::vector<std::int32_t> number(mesh.positions.size(), -1);
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) {
    if (parts.of_vertex[v] < 0) continue;
    PolygonMesh& part = meshes[parts.of_vertex[v]];
    number[v] = part.vertex_count();
    part.positions.push_back(mesh.positions[v]);
  }
  std::vector<std::int32_t> face;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    face.clear();
    for (const std::int32_t v : mesh.face(f)) face.push_back(number[v]);
    meshes[parts.of_vertex[mesh.face(f)[0]]].add_face(face);
  }
  for (const CreaseEdge& crease : mesh.creases)
    if (const std::int32_t part = parts.of_vertex[crease.v0]; part >= 0)
      meshes[part].creases.push_back({number[crease.v0], number[crease.v1], crease.sharpness});
  return meshes;
}

PolygonMesh some_faces(const PolygonMesh& mesh, std::span<const std::uint8_t> is_kept) {
  PolygonMesh some;
  some.positions = mesh.positions;
  some.uvs = mesh.uvs;
  some.colors = mesh.colors;
  some.attributes = mesh.attributes;
  some.groups = mesh.groups;
  add_faces(some, mesh, [&](std::int32_t f) { return is_kept[f] != 0; });
  return some;
}

void add_other_faces(PolygonMesh& to, const PolygonMesh& mesh,
                     std::span<const std::uint8_t> is_kept) {
  add_faces(to, mesh, [&](std::int32_t f) { return is_kept[f] == 0; });
}

}  // namespace planish
