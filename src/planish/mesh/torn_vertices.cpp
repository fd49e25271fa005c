#include "planish/mesh/torn_vertices.h"

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <numeric>
#include <utility>
#include <vector>

#include "planish/core/counted.h"
#include "planish/mesh/weld_vertices.h"

namespace planish {

namespace {

// Of the diagonal: what is left of one position where a file's numbers have six digits.
constexpr double kNearly = 1e-5;

// Of these vertices within `reach` of each other, and of the open edges between them.
TornVertices torn_within(const PolygonMesh& mesh, const MeshTopology& topology,
                         const std::vector<std::int32_t>& vertices, double reach) {
  PolygonMesh ends;  // one face has them all: its corners say what becomes of each
  for (const std::int32_t v : vertices) ends.positions.push_back(mesh.positions[v]);
  std::vector<std::int32_t> all(vertices.size());
  std::iota(all.begin(), all.end(), 0);
  ends.add_face(all);
  const WeldedMesh welded = weld_vertices(std::move(ends), reach);
  if (welded.welded_count == 0) return {};
  const auto places = welded.mesh.face(0);
  const auto place_of = [&](std::int32_t vertex) {
    return places[std::ranges::lower_bound(vertices, vertex) - vertices.begin()];
  };
  std::vector<std::pair<std::int32_t, std::int32_t>> edges;
  for (std::int32_t edge = 0; edge < topology.edge_count(); ++edge) {
    if (!topology.is_boundary_edge(edge)) continue;
    const auto [a, b] = topology.edge_vertices(edge);
    if (place_of(a) != place_of(b)) edges.emplace_back(std::minmax(place_of(a), place_of(b)));
  }
  std::ranges::sort(edges);
  if (std::ranges::adjacent_find(edges) == edges.end()) return {};
  std::vector<bool> is_taken(welded.mesh.positions.size(), false);
  TornVertices torn{welded.welded_count, -1, reach};
  for (std::size_t i = 0; i < vertices.size() && torn.first < 0; ++i) {
    if (is_taken[places[i]]) torn.first = vertices[i];
    is_taken[places[i]] = true;
  }
  return torn;
}

}  // namespace

TornVertices torn_vertices(const PolygonMesh& mesh, const MeshTopology& topology) {
  std::vector<std::int32_t> vertices;  // at open edges, ascending
  for (std::int32_t v = 0; v < topology.vertex_count(); ++v)
    if (topology.is_boundary_vertex(v)) vertices.push_back(v);
  if (vertices.empty()) return {};
  const TornVertices exactly = torn_within(mesh, topology, vertices, 0);
  return exactly.count > 0 ? exactly : torn_within(mesh, topology, vertices, kNearly);
}

std::string torn_text(const TornVertices& torn) {
  const std::string lie =
      with_separators(torn.count) +
      (torn.count == 1 ? " vertex at open edges lies" : " vertices at open edges lie");
  if (torn.reach == 0) return lie + " exactly where another one does; --weld 0 makes them one";
  char reach[32];
  std::snprintf(reach, sizeof reach, "%g", torn.reach);
  return lie + " within " + reach + " of the diagonal of another one; --weld " + reach +
         " makes them one";
}

}  // namespace planish
