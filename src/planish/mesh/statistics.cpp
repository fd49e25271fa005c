#include "planish/mesh/statistics.h"

#include "planish/mesh/disjoint_sets.h"
#include "planish/mesh/edge_groups.h"

namespace planish {
namespace {

void count_one(std::vector<std::int64_t>& counts, std::int32_t entry) {
  if (counts.size() <= static_cast<std::size_t>(entry)) counts.resize(entry + 1, 0);
  ++counts[entry];
}

}  // namespace

MeshStatistics statistics(const PolygonMesh& mesh) {
  MeshStatistics result;
  result.vertex_count = mesh.vertex_count();
  result.face_count = mesh.face_count();
  for (std::int32_t face = 0; face < mesh.face_count(); ++face)
    count_one(result.face_size_counts, mesh.face_size(face));

  const std::vector<std::uint8_t> all_faces(mesh.face_count(), 1);
  std::vector<std::int32_t> valences(mesh.vertex_count(), 0);
  std::vector<std::uint8_t> on_boundary(mesh.vertex_count(), 0);
  DisjointSets components(mesh.vertex_count());
  DisjointSets loops(mesh.vertex_count());
  std::int64_t component_joins = 0, loop_joins = 0;
  group_edges(mesh, all_faces).for_each([&](std::int32_t lower, std::span<const FaceSide> sides) {
    const std::int32_t higher = sides.front().higher;
    ++result.edge_count;
    ++valences[lower];
    ++valences[higher];
    component_joins += components.unite(lower, higher);
    if (sides.size() > 1) return;
    on_boundary[lower] = on_boundary[higher] = 1;
    loop_joins += loops.unite(lower, higher);
  });

  std::int64_t boundary_vertices = 0;
  for (std::int32_t vertex = 0; vertex < mesh.vertex_count(); ++vertex) {
    boundary_vertices += on_boundary[vertex];
    if (valences[vertex] == 0) {
      ++result.unused_vertex_count;
    } else {
      count_one(result.valence_counts, valences[vertex]);
    }
  }
  // Each boundary vertex of a checked mesh has two boundary edges, so that loops and connected
  // sets of boundary vertices are the same.
  result.boundary_loop_count = boundary_vertices - loop_joins;
  const std::int64_t used = result.vertex_count - result.unused_vertex_count;
  result.component_count = used - component_joins;
  // Euler-Poincare: V - E + F + loops = sum over components of 2 - 2 genus.
  const std::int64_t euler =
      used - result.edge_count + result.face_count + result.boundary_loop_count;
  result.genus = result.component_count - euler / 2;
  return result;
}

}  // namespace planish
