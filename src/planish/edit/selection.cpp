#include "planish/edit/selection.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <queue>
#include <string>
#include <unordered_map>
#include <utility>

#include "planish/core/error.h"

namespace planish {

Selection select_around(const PreparedMesh& prepared, std::span<const glm::dvec3> positions,
                        std::span<const std::int32_t> vertices, double radius) {
  if (!(radius > 0) || !std::isfinite(radius)) {
    throw Error(ErrorCode::InvalidArgument,
                "the radius " + std::to_string(radius) +
                    " is not above 0 and finite; take a length in the mesh's unit");
  }
  const MeshTopology& topology = *prepared.topology;
  const auto position = [&](std::int32_t used) -> const glm::dvec3& {
    return positions[prepared.vertices[used]];
  };
  // Dijkstra; ties go by the vertex, so that the order is always the same.
  using Reached = std::pair<double, std::int32_t>;
  std::priority_queue<Reached, std::vector<Reached>, std::greater<>> open;
  std::unordered_map<std::int32_t, double> distances;
  const auto reach = [&](std::int32_t vertex, double distance) {
    const auto [at, is_new] = distances.try_emplace(vertex, distance);
    if (!is_new && at->second <= distance) return;
    at->second = distance;
    open.push({distance, vertex});
  };
  for (const std::int32_t vertex : vertices) {
    const auto used = std::ranges::lower_bound(prepared.vertices, vertex);
    if (used != prepared.vertices.end() && *used == vertex)
      reach(static_cast<std::int32_t>(used - prepared.vertices.begin()), 0);
  }
  Selection result;
  while (!open.empty()) {
    const auto [distance, vertex] = open.top();
    open.pop();
    if (distance > distances[vertex]) continue;
    const double part = distance / radius, fall = 1 - part * part;
    result.vertices.push_back(prepared.vertices[vertex]);
    result.weights.push_back(fall * fall);
    for (const std::int32_t corner : topology.corners_at(vertex)) {
      for (const std::int32_t c : {topology.next(corner), topology.prev(corner)}) {
        const std::int32_t other = topology.vertex_of(c);
        const double there = distance + glm::length(position(other) - position(vertex));
        if (there < radius) reach(other, there);
      }
    }
  }
  return result;
}

}  // namespace planish
