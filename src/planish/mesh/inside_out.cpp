#include "planish/mesh/inside_out.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <span>
#include <vector>

#include "planish/core/concurrent_sets.h"
#include "planish/core/parallel.h"
#include "planish/mesh/area_vector.h"

namespace planish {

namespace {

constexpr std::size_t kInsideOutGrain = 1 << 14;
// Of its box: a closed part of less volume is a sheet.
constexpr double kThin = 1e-6;
// Parts that are asked whether one is within them: with more around it that stays open.
constexpr std::size_t kMostHosts = 256;

struct ClosedPart {
  double volume = 0;  // signed, below 0 where faces look inward
  glm::dvec3 low{std::numeric_limits<double>::max()}, high{-std::numeric_limits<double>::max()};
  std::int32_t first_face = -1;
  bool is_open = false;

  [[nodiscard]] bool is_solid() const {
    const glm::dvec3 size = high - low;
    return !is_open && std::abs(volume) > kThin * size.x * size.y * size.z;
  }
  [[nodiscard]] bool holds(const ClosedPart& other) const {
    return glm::all(glm::lessThanEqual(low, other.low)) &&
           glm::all(glm::lessThanEqual(other.high, high));
  }
};

// By the first vertex of each part, of which all others know.
std::vector<std::int32_t> first_vertices(const MeshTopology& topology) {
  const auto count = static_cast<std::size_t>(topology.vertex_count());
  ConcurrentSets sets(count);
  parallel_each(topology.edge_count(), kInsideOutGrain, [&](std::int32_t e) {
    const auto [v, w] = topology.edge_vertices(e);
    sets.unite(v, w);
  });
  std::vector<std::int32_t> first(count);
  parallel_each(count, kInsideOutGrain, [&](std::int32_t v) { first[v] = sets.find(v); });
  return first;
}

// What a face and a point enclose, three times; below 0 where the face looks at the point.
double volume_of(const PolygonMesh& mesh, std::span<const std::int32_t> face,
                 const glm::dvec3& about) {
  return glm::dot(mesh.positions[face[0]] - about, area_vector(mesh.positions, face));
}

// What a closed part holds, three times.
double volume_of(const PolygonMesh& mesh, const MeshTopology& topology) {
  return ordered_reduce(
      static_cast<std::size_t>(topology.face_count()), kInsideOutGrain, 0.0,
      [&](std::size_t begin, std::size_t end) {
        double sum = 0;
        for (std::size_t f = begin; f < end; ++f)
          sum += volume_of(mesh, topology.face(static_cast<std::int32_t>(f)), mesh.positions[0]);
        return sum;
      },
      [](double& total, double part) { total += part; });
}

std::vector<ClosedPart> parts_of(const PolygonMesh& mesh, const MeshTopology& topology) {
  const std::vector<std::int32_t> first = first_vertices(topology);
  std::vector<std::int32_t> part_of(first.size(), -1);
  std::vector<ClosedPart> parts;
  for (std::int32_t f = 0; f < topology.face_count(); ++f) {
    const auto face = topology.face(f);
    const std::int32_t root = first[face[0]];
    if (part_of[root] < 0) {
      part_of[root] = static_cast<std::int32_t>(parts.size());
      parts.push_back({.first_face = f});
    }
    ClosedPart& part = parts[part_of[root]];
    part.volume += volume_of(mesh, face, mesh.positions[root]) / 3;
    for (const std::int32_t v : face) {
      part.low = glm::min(part.low, mesh.positions[v]);
      part.high = glm::max(part.high, mesh.positions[v]);
    }
  }
  for (std::int32_t e = 0; e < topology.edge_count(); ++e)
    if (topology.is_boundary_edge(e))
      parts[part_of[first[topology.edge_vertices(e).first]]].is_open = true;
  return parts;
}

}  // namespace

InsideOutParts inside_out_parts(const PolygonMesh& mesh, const MeshTopology& topology,
                                std::int64_t component_count) {
  if (component_count == 1 && volume_of(mesh, topology) > 0) return {};
  std::vector<ClosedPart> solids = parts_of(mesh, topology);
  std::erase_if(solids, [](const ClosedPart& part) { return !part.is_solid(); });
  std::ranges::stable_sort(solids, {}, [](const ClosedPart& part) { return part.low.x; });
  InsideOutParts found;
  for (std::size_t i = 0; i < solids.size(); ++i) {
    if (solids[i].volume > 0) continue;
    // What holds it begins before it.
    const std::size_t asked = std::min(i, kMostHosts);
    const auto hosts = std::span(solids).subspan(i - asked, asked);
    const auto holds = [&](const ClosedPart& host) { return host.holds(solids[i]); };
    if (asked < i || std::ranges::any_of(hosts, holds)) continue;
    ++found.count;
    if (found.first_face < 0 || solids[i].first_face < found.first_face)
      found.first_face = solids[i].first_face;
  }
  return found;
}

}  // namespace planish
