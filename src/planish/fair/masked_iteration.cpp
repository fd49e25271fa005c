// Based on: "Smooth Surface Reconstruction using Doo-Sabin Subdivision Surfaces", section 3.2: the
// iteration of progressive interpolation, here weighted per vertex.
#include "planish/fair/masked_iteration.h"

#include "planish/core/parallel.h"
#include "planish/fair/corner_offsets.h"

namespace planish {

using glm::dvec3;

namespace {

constexpr std::size_t kStepGrain = 8192;
constexpr int kSteps = 3;

}  // namespace

dvec3 limit_error(const FairTopology& topology, std::span<const dvec3> given,
                  std::span<const dvec3> points, std::span<const dvec3> offsets,
                  std::int32_t vertex) {
  if (topology.has_polygon(vertex)) {
    dvec3 sum(0.0);
    for (const std::int32_t corner : topology.ring(vertex).corners) sum += offsets[corner];
    return sum / static_cast<double>(topology.valence(vertex));
  }
  if (topology.kind(vertex) == VertexKind::Corner) return dvec3(0.0);
  const auto [before, after] = topology.crease_neighbours(vertex);
  const dvec3& own = points[vertex];
  return (own - given[vertex]) + ((points[before] - own) + (points[after] - own)) / 8.0;
}

std::vector<dvec3> masked_iteration(const FairTopology& topology, std::span<const dvec3> given,
                                    std::span<const double> shares, std::span<dvec3> offsets,
                                    FairHalo* halo) {
  std::vector<dvec3> points(given.begin(), given.end());
  std::vector<dvec3> next = points;
  for (int step = 0; step < kSteps; ++step) {
    parallel_each(points.size(), kStepGrain, [&](std::int32_t v) {
      if (shares[v] <= 0) return;
      next[v] = points[v] - shares[v] * limit_error(topology, given, points, offsets, v);
    });
    std::swap(points, next);
    if (halo) halo->exchange_vertices(points);
    corner_offsets(topology, given, points, offsets);
  }
  return points;
}

}  // namespace planish
