#include "planish/mesh/prepared_mesh.h"

#include <numeric>
#include <optional>
#include <utility>

#include "planish/core/assert.h"
#include "planish/core/prefix_sum.h"
#include "planish/mesh/check.h"
#include "planish/mesh/sound_topology.h"
#include "planish/mesh/used_vertices.h"

namespace planish {

namespace {

std::shared_ptr<const PreparedMesh> prepared_of(const PolygonMesh& mesh,
                                                std::optional<MeshTopology> topology) {
  auto prepared = std::make_shared<PreparedMesh>();
  prepared->given_vertex_count = mesh.vertex_count();
  const auto is_used = [&](std::int32_t v) { return !topology->corners_at(v).empty(); };
  const auto count = static_cast<std::size_t>(mesh.vertex_count());
  const SelectedBlocks blocks = count_selected(count, is_used);
  prepared->vertices.resize(blocks.total);
  for_selected(count, blocks, is_used, [&](std::size_t v, std::int32_t number) {
    prepared->vertices[number] = static_cast<std::int32_t>(v);
  });
  if (!prepared->uses_all()) topology.emplace(without_unused_vertices(mesh).mesh);
  prepared->topology = std::make_shared<const MeshTopology>(std::move(*topology));
  return prepared;
}

}  // namespace

std::shared_ptr<const PreparedMesh> prepare_if_sound(const PolygonMesh& mesh) {
  std::optional<MeshTopology> topology = sound_topology(mesh);
  if (!topology) {
    if (!check(mesh).empty()) return nullptr;
    topology.emplace(mesh);
  }
  return prepared_of(mesh, std::move(topology));
}

std::shared_ptr<const PreparedMesh> prepare_mesh(const PolygonMesh& mesh, std::string_view name) {
  return prepared_of(mesh, usable_topology(mesh, name));
}

std::shared_ptr<const PreparedMesh> prepared_whole(const PolygonMesh& mesh,
                                                   std::shared_ptr<const MeshTopology> topology) {
  auto prepared = std::make_shared<PreparedMesh>();
  prepared->given_vertex_count = mesh.vertex_count();
  prepared->vertices.resize(mesh.positions.size());
  std::iota(prepared->vertices.begin(), prepared->vertices.end(), 0);
  prepared->topology = std::move(topology);
  return prepared;
}

UsedPart used_part(const PolygonMesh& mesh, std::shared_ptr<const PreparedMesh> prepared) {
  PLANISH_ASSERT(mesh.vertex_count() == prepared->given_vertex_count);
  PLANISH_ASSERT(mesh.face_count() == prepared->topology->face_count());
  const std::span<const std::int32_t> vertices = prepared->vertices;
  if (prepared->uses_all()) return {std::move(prepared), nullptr, mesh, vertices};
  auto copy = std::make_unique<const PolygonMesh>(without_unused_vertices(mesh).mesh);
  const PolygonMesh& used = *copy;
  return {std::move(prepared), std::move(copy), used, vertices};
}

}  // namespace planish
