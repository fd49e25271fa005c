#include "planish/mesh/used_vertices.h"

#include <atomic>
#include <cstddef>

#include "planish/core/parallel.h"
#include "planish/core/prefix_sum.h"
#include "planish/core/raw_vector.h"

namespace planish {
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

}  // namespace planish
