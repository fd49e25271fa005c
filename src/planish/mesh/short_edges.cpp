#include "planish/mesh/short_edges.h"

#include <algorithm>
#include <cstddef>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <unordered_map>
#include <utility>

#include "planish/core/parallel.h"
#include "planish/mesh/disjoint_sets.h"
#include "planish/mesh/placement.h"
#include "planish/mesh/sound_topology.h"

namespace planish {

namespace {

// What edges of no length join.
struct Cluster {
  glm::dvec3 low, high;
  double reach = 0;  // the longest edge that leads away, in diagonals
};

bool faces_are_in_range(const PolygonMesh& mesh) {
  const auto corners = static_cast<std::int32_t>(mesh.face_vertices.size());
  return std::max(mesh.positions.size(), mesh.face_vertices.size()) <=
             static_cast<std::size_t>(kMaxInt32) &&
         !mesh.face_offsets.empty() && mesh.face_offsets.front() == 0 &&
         mesh.face_offsets.back() == corners && std::ranges::is_sorted(mesh.face_offsets) &&
         std::ranges::all_of(mesh.face_vertices,
                             [&](std::int32_t v) { return v >= 0 && v < mesh.vertex_count(); });
}

// Edges in units of the diagonal, whose squares are numbers however small the mesh is.
struct Edges {
  const PolygonMesh& mesh;
  double diagonal;

  // Calls visit(v0, v1, length) for those of these faces, twice where two faces are.
  template <class Visit>
  void visit(std::size_t begin, std::size_t end, const Visit& visit) const {
    for (std::size_t f = begin; f < end; ++f) {
      const auto face = mesh.face(static_cast<std::int32_t>(f));
      for (std::size_t i = 0; i < face.size(); ++i) {
        const std::int32_t v0 = face[i], v1 = face[i + 1 < face.size() ? i + 1 : 0];
        if (v0 == v1) continue;
        visit(v0, v1, glm::length((mesh.positions[v1] - mesh.positions[v0]) / diagonal));
      }
    }
  }
};

}  // namespace

std::vector<std::int32_t> short_edge_targets(const PolygonMesh& mesh) {
  if (!faces_are_in_range(mesh) || !positions_are_finite(mesh)) return {};
  const Edges edges{mesh, placement_of(mesh).diagonal};
  const auto face_count = static_cast<std::size_t>(mesh.face_count());
  const bool is_any = ordered_reduce(
      face_count, 4096, false,
      [&](std::size_t begin, std::size_t end) {
        bool found = false;
        edges.visit(begin, end, [&](auto, auto, double length) { found |= length <= kShortEdge; });
        return found;
      },
      [](bool& total, bool found) { total |= found; });
  if (!is_any) return {};

  DisjointSets joined(mesh.positions.size());
  edges.visit(0, face_count, [&](std::int32_t v0, std::int32_t v1, double length) {
    if (length <= kShortEdge) joined.unite(v0, v1);
  });
  std::unordered_map<std::int32_t, Cluster> clusters;  // by their first vertex
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) {
    const std::int32_t first = joined.find(v);
    if (first == v) continue;
    const glm::dvec3 &start = mesh.positions[first], &own = mesh.positions[v];
    Cluster& cluster = clusters.try_emplace(first, Cluster{start, start}).first->second;
    cluster.low = glm::min(cluster.low, own);
    cluster.high = glm::max(cluster.high, own);
  }
  edges.visit(0, face_count, [&](std::int32_t v0, std::int32_t v1, double length) {
    const std::int32_t first0 = joined.find(v0), first1 = joined.find(v1);
    if (first0 == first1) return;
    for (const std::int32_t first : {first0, first1}) {
      const auto found = clusters.find(first);
      if (found != clusters.end()) found->second.reach = std::max(found->second.reach, length);
    }
  });
  DisjointSets taken(mesh.positions.size());
  bool takes_any = false;
  edges.visit(0, face_count, [&](std::int32_t v0, std::int32_t v1, double length) {
    if (length > kShortEdge) return;
    const Cluster& cluster = clusters.at(joined.find(v0));
    const double extent = glm::length((cluster.high - cluster.low) / edges.diagonal);
    if (length > 0 && extent > kShortShare * cluster.reach) return;
    taken.unite(v0, v1);
    takes_any = true;
  });
  if (!takes_any) return {};
  std::vector<std::int32_t> targets(mesh.positions.size());
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) targets[v] = taken.find(v);
  return targets;
}

}  // namespace planish
