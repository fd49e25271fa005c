#include "planish/limit/sheet_gap.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <vector>

#include "planish/core/parallel.h"

namespace planish {

namespace {

constexpr std::size_t kGapGrain = 64;
constexpr int kHalf = 8;  // steps from an end to the middle of an edge

using Curve = std::array<glm::dvec3, 2 * kHalf + 1>;

// A side of a face over one of the edges.
struct Side {
  std::int64_t edge;    // its place in the list
  std::int32_t corner;  // where it begins
};

std::vector<Side> sides_on(const LimitSurface& surface,
                           std::span<const std::int32_t> source_vertices,
                           std::span<const std::pair<std::int32_t, std::int32_t>> edges) {
  const MeshTopology& topology = surface.topology();
  const std::span<const std::int32_t> given = surface.surface().used().vertices;
  const auto source_of = [&](std::int32_t corner) {
    return source_vertices[given[topology.vertex_of(corner)]];
  };
  std::vector<Side> sides;
  for (std::int32_t c = 0; c < topology.corner_count(); ++c) {
    if (topology.twin(c) >= 0) continue;
    const std::int32_t v = source_of(c), w = source_of(topology.next(c));
    const std::pair<std::int32_t, std::int32_t> ends(std::min(v, w), std::max(v, w));
    const auto place = std::ranges::lower_bound(edges, ends);
    if (place != edges.end() && *place == ends) sides.push_back({place - edges.begin(), c});
  }
  std::ranges::stable_sort(sides, {}, &Side::edge);
  return sides;
}

// The boundary of the surface over a side, from its middle to both ends by (u, 0) and (0, v).
Curve curve_over(const LimitSurface& surface, std::int32_t corner) {
  const MeshTopology& topology = surface.topology();
  const std::int32_t next = topology.next(corner);
  Curve curve;
  for (int i = 0; i <= kHalf; ++i) {
    const double at = static_cast<double>(i) / kHalf;
    curve[i] = surface.evaluate(surface_parameter(topology, corner, at, 0)).position;
    curve[2 * kHalf - i] = surface.evaluate(surface_parameter(topology, next, 0, at)).position;
  }
  return curve;
}

double distance_to(const Curve& curve, const glm::dvec3& point) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < curve.size(); ++i) {
    const glm::dvec3 along = curve[i] - curve[i - 1], to = point - curve[i - 1];
    const double square = glm::dot(along, along);
    const double t = square > 0 ? std::clamp(glm::dot(to, along) / square, 0.0, 1.0) : 0;
    least = std::min(least, glm::length(to - t * along));
  }
  return least;
}

double gap_between(const Curve& a, const Curve& b) {
  double gap = 0;
  for (const glm::dvec3& point : a) gap = std::max(gap, distance_to(b, point));
  for (const glm::dvec3& point : b) gap = std::max(gap, distance_to(a, point));
  return gap;
}

}  // namespace

double sheet_gap(const LimitSurface& surface, std::span<const std::int32_t> source_vertices,
                 std::span<const std::pair<std::int32_t, std::int32_t>> edges) {
  const std::vector<Side> sides = sides_on(surface, source_vertices, edges);
  std::vector<std::size_t> starts;
  for (std::size_t i = 0; i < sides.size(); ++i)
    if (i == 0 || sides[i].edge != sides[i - 1].edge) starts.push_back(i);
  std::vector<double> gaps(starts.size(), 0);
  parallel_each(starts.size(), kGapGrain, [&](std::size_t e) {
    const std::size_t last = e + 1 < starts.size() ? starts[e + 1] : sides.size();
    const Curve first = curve_over(surface, sides[starts[e]].corner);
    for (std::size_t i = starts[e] + 1; i < last; ++i)
      gaps[e] = std::max(gaps[e], gap_between(first, curve_over(surface, sides[i].corner)));
  });
  return gaps.empty() ? 0 : *std::ranges::max_element(gaps);
}

}  // namespace planish
