#include "planish/mesh/coarse_balls.h"

#include <algorithm>
#include <cstdint>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <vector>

#include "planish/mesh/coherent_edges.h"
#include "planish/mesh/disjoint_sets.h"

namespace planish {
namespace {

constexpr double kAlikeTurns = 1.2;
constexpr double kRoundness = 3.05;  // a tetrahedron has 3

struct ConnectedPart {
  double flattest = std::numbers::pi, sharpest = 0;  // turns of edges
  // Of the faces' planes from the middle, below 0 where they look at it; and of the vertices.
  double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
  double farthest = 0;
  glm::dvec3 middle{0.0};
  std::int64_t vertex_count = 0;

  [[nodiscard]] bool is_ball() const {
    const double nearest = std::max(lowest, -highest);  // all look outward, or all inward
    return sharpest <= kAlikeTurns * flattest && farthest <= kRoundness * nearest;
  }
};

}  // namespace

bool are_coarse_balls(const PolygonMesh& mesh, const MeshTopology& topology,
                      std::span<const glm::dvec3> areas) {
  DisjointSets sets(mesh.positions.size());
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    for (const std::int32_t v : mesh.face(f)) sets.unite(mesh.face(f).front(), v);
  std::vector<ConnectedPart> parts(mesh.positions.size());  // at the first vertex of each
  const auto part_of = [&](std::int32_t v) -> ConnectedPart& { return parts[sets.find(v)]; };
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) {
    part_of(v).middle += mesh.positions[v];
    ++part_of(v).vertex_count;
  }
  for (ConnectedPart& part : parts)
    if (part.vertex_count > 0) part.middle /= static_cast<double>(part.vertex_count);
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) {
    ConnectedPart& part = part_of(v);
    part.farthest = std::max(part.farthest, glm::distance(mesh.positions[v], part.middle));
  }
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const std::int32_t first = mesh.face(f).front();
    ConnectedPart& part = part_of(first);
    const double length = glm::length(areas[f]);
    const double along = glm::dot(mesh.positions[first] - part.middle, areas[f]);
    const double off = length > 0 ? along / length : 0;
    part.lowest = std::min(part.lowest, off);
    part.highest = std::max(part.highest, off);
  }
  const EdgeTurns turns(mesh, topology, areas);
  for (std::int32_t e = 0; e < topology.edge_count(); ++e) {
    if (topology.is_boundary_edge(e)) continue;
    const double turn = turns.turn(e);
    ConnectedPart& part = part_of(topology.edge_vertices(e).first);
    part.flattest = std::min(part.flattest, turn);
    part.sharpest = std::max(part.sharpest, turn);
  }
  return std::ranges::all_of(
      parts, [](const ConnectedPart& part) { return part.vertex_count == 0 || part.is_ball(); });
}

}  // namespace planish
