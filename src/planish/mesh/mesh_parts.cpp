#include "planish/mesh/mesh_parts.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <optional>
#include <string>
#include <tuple>

#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/mesh/edge_groups.h"
#include "planish/mesh/sound_topology.h"

namespace planish {

std::vector<std::uint8_t> hole_flags(const PolygonMesh& mesh) {
  std::vector<std::uint8_t> flags(static_cast<std::size_t>(mesh.face_count()), 0);
  for (std::size_t i = 0; i < mesh.hole_faces.size(); ++i) {
    const std::int32_t face = mesh.hole_faces[i];
    if (face < 0 || face >= mesh.face_count())
      throw Error(ErrorCode::UnusableMesh,
                  formatted("hole {} is face {} of {}", i, face, mesh.face_count()),
                  static_cast<std::int64_t>(i));
    flags[face] = 1;
  }
  return flags;
}

namespace {

constexpr std::size_t kGrain = 4096;

template <class Body>
void for_each(std::size_t count, const Body& body) {
  parallel_each(count, kGrain, [&](std::size_t i) { body(i); });
}

}  // namespace

UsedMesh without_unused_vertices(const PolygonMesh& mesh) {
  RawVector<std::uint8_t> is_named(mesh.positions.size());
  for_each(is_named.size(), [&](std::size_t v) { is_named[v] = 0; });
  for_each(mesh.face_vertices.size(), [&](std::size_t c) {
    std::atomic_ref(is_named[mesh.face_vertices[c]]).store(1, std::memory_order_relaxed);
  });
  const auto is_used = [&](std::size_t v) { return is_named[v] != 0; };
  const SelectedBlocks blocks = count_selected(is_named.size(), is_used);
  UsedMesh used;
  used.vertices.resize(blocks.total);
  RawVector<std::int32_t> new_index(mesh.positions.size());
  for_each(new_index.size(), [&](std::size_t v) { new_index[v] = -1; });
  for_selected(is_named.size(), blocks, is_used, [&](std::size_t v, std::int32_t number) {
    used.vertices[number] = static_cast<std::int32_t>(v);
    new_index[v] = number;
  });
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
  used.mesh.positions.resize(used.vertices.size());
  used.mesh.colors.resize(mesh.colors.empty() ? 0 : used.vertices.size());
  for_each(used.vertices.size(), [&](std::size_t v) {
    used.mesh.positions[v] = mesh.positions[used.vertices[v]];
    if (!mesh.colors.empty()) used.mesh.colors[v] = mesh.colors[used.vertices[v]];
  });
  used.mesh.attributes = attributes_of(mesh.attributes, used.vertices);
  used.mesh.face_vertices.resize(mesh.face_vertices.size());
  for_each(mesh.face_vertices.size(),
           [&](std::size_t c) { used.mesh.face_vertices[c] = new_index[mesh.face_vertices[c]]; });
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

FaceComponents face_components(const MeshTopology& topology) {
  const std::int32_t count = topology.face_count();
  DisjointSets sets(static_cast<std::size_t>(count));
  for (std::int32_t e = 0; e < topology.edge_count(); ++e) {
    const std::int32_t corner = topology.corner_of(e), twin = topology.twin(corner);
    if (twin >= 0) sets.unite(topology.face_of(corner), topology.face_of(twin));
  }
  FaceComponents parts{std::vector<std::int32_t>(static_cast<std::size_t>(count)), 0};
  // The first face of a set is its root.
  for (std::int32_t f = 0; f < count; ++f) {
    const std::int32_t root = sets.find(f);
    parts.of_face[f] = root == f ? parts.count++ : parts.of_face[root];
  }
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
