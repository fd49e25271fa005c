#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

#include "planish/fair/fair_topology.h"
#include "planish/fair/planar_ring.h"

namespace planish {

/// How far a vertex takes part in the tensor-product construction, 0 to 1: only among quads, and
/// the less the farther its control points are out of balance, be it by themselves or against those
/// of its neighbours. Continuous in the given points. `corner_offsets`: of one step of them;
/// `normal`: the vertex's, unit; `scratch` is reused from vertex to vertex.
[[nodiscard]] double tensor_share(const FairTopology& topology, std::span<const glm::dvec3> given,
                                  std::span<const glm::dvec3> corner_offsets,
                                  const glm::dvec3& normal, std::int32_t vertex,
                                  PlanarRing& scratch);

}  // namespace planish
