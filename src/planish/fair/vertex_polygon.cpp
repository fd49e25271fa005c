#include "planish/fair/vertex_polygon.h"

#include <glm/geometric.hpp>

#include "planish/fair/corner_offsets.h"
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
  for (const std::int32_t corner : topology.ring(vertex).corners) sum += offsets[corner];
  return sum / static_cast<double>(topology.valence(vertex));
}

void centre(const FairTopology& topology, std::span<dvec3> offsets, std::int32_t vertex) {
  const dvec3 mean = mean_of(topology, offsets, vertex);
  for (const std::int32_t corner : topology.ring(vertex).corners) offsets[corner] -= mean;
}

bool is_reversed(const FairTopology& topology, std::span<const dvec3> offsets, std::int32_t vertex,
                 const dvec3& normal) {
  const auto corners = topology.ring(vertex).corners;
  const dvec3 own = limit_normal(topology, topology.valence(vertex),
                                 [&](std::int32_t i) { return offsets[corners[i]]; });
  return glm::dot(own, normal) < kReversedCosine * glm::length(own);
}

void build_local(const FairTopology& topology, std::span<const dvec3> given, std::int32_t vertex,
                 const PolygonShape& shape, PolygonScratch& scratch, std::span<dvec3> offsets) {
  const dvec3& normal = shape.normal;
  const FairTopology::Ring ring = topology.ring(vertex);
  const std::int32_t n = ring.size();
  const VertexFrame frame = frame_of(normal);
  project_ring(given, offsets, vertex, ring, frame, scratch.ring);
  build_local_polygon(scratch.ring, imbalance(scratch.ring), scratch.local);
  if (topology.is_regular[vertex] && !shape.is_flat) {
    scratch.heights.resize(static_cast<std::size_t>(n));
    for (std::int32_t i = 0; i < n; ++i) {
      scratch.heights[i] = glm::dot(offsets[ring.corners[i]], normal);
    }
    add_twist(scratch.ring, scratch.heights, scratch.local);
  }
  for (std::int32_t i = 0; i < n; ++i) {
    const glm::dvec2& flat = scratch.local.points[i];
    offsets[ring.corners[i]] =
        flat.x * frame.tangent1 + flat.y * frame.tangent2 + scratch.local.heights[i] * frame.normal;
  }
}

}  // namespace

bool build_vertex_polygon(const FairTopology& topology, std::span<const dvec3> given,
                          const GivenStep& step, std::int32_t vertex, const PolygonShape& shape,
                          PolygonScratch& scratch, std::span<dvec3> offsets) {
  const auto corners = topology.ring(vertex).corners;
  const std::int32_t n = topology.valence(vertex);
  // Two control points only: translation puts them on both sides of the vertex.
  const double share = n > 2 ? shape.share : 1.0;
  if (share > 0 && share < 1) {
    const dvec3 mean = mean_of(topology, offsets, vertex);
    scratch.translated.resize(static_cast<std::size_t>(n));
    for (std::int32_t i = 0; i < n; ++i) {
      scratch.translated[i] = offsets[corners[i]] - mean;
    }
  }
  if (share < 1) build_local(topology, given, vertex, shape, scratch, offsets);
  if (share > 0 && share < 1) {
    for (std::int32_t i = 0; i < n; ++i) {
      dvec3& offset = offsets[corners[i]];
      offset = share * scratch.translated[i] + (1 - share) * offset;
    }
  }
  const bool reversed =
      shape.reversed ? *shape.reversed : is_reversed(topology, offsets, vertex, shape.normal);
  if (reversed) {
    for (const std::int32_t corner : corners)
      offsets[corner] = kReversedFactor * step.offset(corner);
  }
  centre(topology, offsets, vertex);
  return reversed;
}

}  // namespace planish
