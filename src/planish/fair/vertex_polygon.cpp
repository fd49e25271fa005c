#include "planish/fair/vertex_polygon.h"

#include <glm/geometric.hpp>

#include "planish/fair/limit_normal.h"
#include "planish/fair/vertex_frame.h"

namespace planish {

using glm::dvec3;

namespace {

// Cosine between the polygon's limit normal and the vertex's below which it counts as turned over.
constexpr double kReversedCosine = 0.2;
constexpr double kReversedFactor = 0.3;

dvec3 mean_of(const FairTopology& topology, std::span<const dvec3> offsets, std::int32_t vertex) {
  dvec3 sum(0.0);
  for (std::int32_t i = topology.ring_offsets[vertex]; i < topology.ring_offsets[vertex + 1]; ++i) {
    sum += offsets[topology.ring_corners[i]];
  }
  return sum / static_cast<double>(topology.valence(vertex));
}

void centre(const FairTopology& topology, std::span<dvec3> offsets, std::int32_t vertex) {
  const dvec3 mean = mean_of(topology, offsets, vertex);
  for (std::int32_t i = topology.ring_offsets[vertex]; i < topology.ring_offsets[vertex + 1]; ++i) {
    offsets[topology.ring_corners[i]] -= mean;
  }
}

bool is_reversed(const FairTopology& topology, std::span<const dvec3> offsets, std::int32_t vertex,
                 const dvec3& normal) {
  const std::int32_t first = topology.ring_offsets[vertex];
  const dvec3 own = limit_normal(topology, topology.valence(vertex), [&](std::int32_t i) {
    return offsets[topology.ring_corners[first + i]];
  });
  return glm::dot(own, normal) < kReversedCosine * glm::length(own);
}

void build_local(const FairTopology& topology, std::span<const dvec3> given, std::int32_t vertex,
                 const PolygonShape& shape, PolygonScratch& scratch, std::span<dvec3> result) {
  const std::int32_t first = topology.ring_offsets[vertex];
  const std::int32_t n = topology.valence(vertex);
  const VertexFrame frame = frame_of(shape.normal);
  project_ring(topology, given, shape.offsets, vertex, first, n, frame, scratch.ring);
  build_local_polygon(scratch.ring, imbalance(scratch.ring), scratch.local);
  if (topology.is_regular[vertex]) {
    if (scratch.heights.size() < static_cast<std::size_t>(n)) {
      scratch.heights.resize(static_cast<std::size_t>(n));
    }
    for (std::int32_t i = 0; i < n; ++i) {
      scratch.heights[i] = glm::dot(shape.offsets[topology.ring_corners[first + i]], shape.normal);
    }
    add_twist(scratch.ring, scratch.heights, scratch.local);
  }
  for (std::int32_t i = 0; i < n; ++i) {
    const glm::dvec2& flat = scratch.local.points[i];
    result[topology.ring_corners[first + i]] =
        flat.x * frame.tangent1 + flat.y * frame.tangent2 + scratch.local.heights[i] * frame.normal;
  }
}

}  // namespace

bool build_vertex_polygon(const FairTopology& topology, std::span<const dvec3> given,
                          std::int32_t vertex, const PolygonShape& shape, PolygonScratch& scratch,
                          std::span<dvec3> result) {
  const std::int32_t first = topology.ring_offsets[vertex];
  const std::int32_t end = topology.ring_offsets[vertex + 1];
  // Two control points only: translation puts them on both sides of the vertex.
  const double share = end - first > 2 ? shape.share : 1.0;
  if (share < 1) {
    build_local(topology, given, vertex, shape, scratch, result);
  }
  if (share > 0) {
    const dvec3 mean = mean_of(topology, shape.offsets, vertex);
    for (std::int32_t i = first; i < end; ++i) {
      const std::int32_t corner = topology.ring_corners[i];
      const dvec3 translated = shape.offsets[corner] - mean;
      result[corner] = share < 1 ? share * translated + (1 - share) * result[corner] : translated;
    }
  }
  const bool reversed = is_reversed(topology, result, vertex, shape.normal);
  if (reversed) {
    for (std::int32_t i = first; i < end; ++i) {
      const std::int32_t corner = topology.ring_corners[i];
      result[corner] = kReversedFactor * shape.given_offsets[corner];
    }
  }
  centre(topology, result, vertex);
  return reversed;
}

}  // namespace planish
