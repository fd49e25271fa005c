#include "planish/mesh/statistics.h"

#include "planish/core/concurrent_sets.h"
#include "planish/core/parallel.h"
#include "planish/core/prefix_sum.h"

namespace planish {
namespace {

constexpr std::size_t kPiece = 1 << 16;  // elements that are counted together

// How often each value of value_of(0 .. count - 1) arises, pieces on all threads.
template <class ValueOf>
std::vector<std::int64_t> histogram(std::int32_t count, const ValueOf& value_of) {
  using Counts = std::vector<std::int64_t>;
  return ordered_reduce(
      static_cast<std::size_t>(count), kPiece, Counts(),
      [&](std::size_t begin, std::size_t end) {
        Counts counts;
        for (std::size_t i = begin; i < end; ++i) {
          const auto value = static_cast<std::size_t>(value_of(static_cast<std::int32_t>(i)));
          if (counts.size() <= value) counts.resize(value + 1, 0);
          ++counts[value];
        }
        return counts;
      },
      [](Counts& total, const Counts& counts) {
        if (total.size() < counts.size()) total.resize(counts.size(), 0);
        for (std::size_t i = 0; i < counts.size(); ++i) total[i] += counts[i];
      });
}

// How many sets fewer the vertices are in once the ends of edges with use_edge are united.
template <class UseEdge>
std::int64_t joins(const MeshTopology& topology, const UseEdge& use_edge) {
  ConcurrentSets sets(static_cast<std::size_t>(topology.vertex_count()));
  return count_selected(static_cast<std::size_t>(topology.edge_count()),
                        [&](std::int32_t edge) {
                          if (!use_edge(edge)) return false;
                          const auto [v0, v1] = topology.edge_vertices(edge);
                          return sets.unite(v0, v1);
                        })
      .total;
}

// Each boundary vertex of a checked mesh has two boundary edges, so that loops and connected sets
// of boundary vertices are the same.
std::int64_t count_boundary_loops(const MeshTopology& topology) {
  const std::int64_t vertices =
      count_selected(static_cast<std::size_t>(topology.vertex_count()), [&](std::int32_t v) {
        return topology.is_boundary_vertex(v);
      }).total;
  if (vertices == 0) return 0;
  return vertices - joins(topology, [&](std::int32_t e) { return topology.is_boundary_edge(e); });
}

MeshStatistics statistics_of(const MeshTopology& topology, std::int64_t vertex_count) {
  MeshStatistics result;
  result.vertex_count = vertex_count;
  result.face_count = topology.face_count();
  result.edge_count = topology.edge_count();
  result.face_size_counts =
      histogram(topology.face_count(), [&](std::int32_t f) { return topology.face_size(f); });
  result.valence_counts =
      histogram(topology.vertex_count(), [&](std::int32_t v) { return topology.valence(v); });
  std::int64_t used = topology.vertex_count();
  if (!result.valence_counts.empty()) {
    used -= result.valence_counts.front();
    result.valence_counts.front() = 0;
    if (used == 0) result.valence_counts.clear();
  }
  result.unused_vertex_count = vertex_count - used;
  result.boundary_loop_count = count_boundary_loops(topology);
  result.component_count = used - joins(topology, [](std::int32_t) { return true; });
  // Euler-Poincare: V - E + F + loops = sum over components of 2 - 2 genus.
  const std::int64_t euler =
      used - result.edge_count + result.face_count + result.boundary_loop_count;
  result.genus = result.component_count - euler / 2;
  return result;
}

}  // namespace

MeshStatistics statistics(const PolygonMesh& mesh) {
  return statistics_of(MeshTopology(mesh), mesh.vertex_count());
}

MeshStatistics statistics(const PreparedMesh& prepared) {
  return statistics_of(*prepared.topology, prepared.given_vertex_count);
}

}  // namespace planish
