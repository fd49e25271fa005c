#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "planish/fair/corner_offsets.h"
#include "planish/fair/fair_topology.h"
#include "planish/fair/local_polygon.h"
#include "planish/fair/planar_ring.h"

namespace planish {

/// Scratch memory of the functions below, reused from vertex to vertex.
struct PolygonScratch {
  PlanarRing ring;
  LocalPolygon local;
  std::vector<double> heights;
  std::vector<glm::dvec3> translated;
};

/// What the polygon of control points around a smooth or dart vertex is built from.
struct PolygonShape {
  glm::dvec3 normal;  ///< of the vertex, unit
  double share;       ///< of the tensor-product construction, 0 to 1
  /// Whether the polygon came out turned over; not given: to be found out.
  std::optional<bool> reversed = std::nullopt;
  bool is_flat = false;  ///< in the plane of the normal, without a twist
};

/// Builds the polygon around `vertex`, its mean exactly 0, in place of its control points in
/// `offsets`, which are those of one step of the given points or of the masked iteration's.
/// True where the built polygon came out turned over and a small translated copy of the given
/// points' stands in for it. `step`: of `given`.
bool build_vertex_polygon(const FairTopology& topology, std::span<const glm::dvec3> given,
                          const GivenStep& step, std::int32_t vertex, const PolygonShape& shape,
                          PolygonScratch& scratch, std::span<glm::dvec3> offsets);

}  // namespace planish
