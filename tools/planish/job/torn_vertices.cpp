#include "job/torn_vertices.h"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "planish/files/shared/weld.h"
#include "terminal/text.h"

namespace planish::command {

TornVertices torn_vertices(const PolygonMesh& mesh, const MeshTopology& topology) {
  std::vector<std::int32_t> vertices;  // at open edges, ascending
  for (std::int32_t v = 0; v < topology.vertex_count(); ++v)
    if (topology.is_boundary_vertex(v)) vertices.push_back(v);
  if (vertices.empty()) return {};
  std::vector<glm::dvec3> positions;
  positions.reserve(vertices.size());
  for (const std::int32_t v : vertices) positions.push_back(mesh.positions[v]);
  const WeldedPositions places = weld(positions);
  if (places.positions.size() == vertices.size()) return {};
  const auto place_of = [&](std::int32_t vertex) {
    const auto found = std::ranges::lower_bound(vertices, vertex);
    return places.indices[found - vertices.begin()];
  };
  std::vector<std::pair<std::int32_t, std::int32_t>> edges;
  for (std::int32_t edge = 0; edge < topology.edge_count(); ++edge) {
    if (!topology.is_boundary_edge(edge)) continue;
    const auto [a, b] = topology.edge_vertices(edge);
    edges.emplace_back(std::minmax(place_of(a), place_of(b)));
  }
  std::ranges::sort(edges);
  if (std::ranges::adjacent_find(edges) == edges.end()) return {};
  std::vector<bool> is_taken(places.positions.size(), false);
  TornVertices torn{std::ssize(vertices) - std::ssize(places.positions), -1};
  for (std::size_t i = 0; i < vertices.size() && torn.first < 0; ++i) {
    if (is_taken[places.indices[i]]) torn.first = vertices[i];
    is_taken[places.indices[i]] = true;
  }
  return torn;
}

std::string torn_text(const TornVertices& torn) {
  return with_separators(torn.count) +
         (torn.count == 1 ? " vertex at open edges lies" : " vertices at open edges lie") +
         " exactly where another one does; --weld 0 makes them one";
}

}  // namespace planish::command
