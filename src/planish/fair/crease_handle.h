#pragma once

#include <glm/vec3.hpp>
#include <span>

#include "planish/fair/corner_offsets.h"
#include "planish/fair/fair_topology.h"

namespace planish {

/// A quarter of the two sharp edges at a crease or boundary vertex, where curve points would stand
/// if nothing had to be interpolated.
struct CreaseArms {
  glm::dvec3 before, after;  ///< towards crease_neighbours()
};

[[nodiscard]] CreaseArms crease_arms(const FairTopology& topology,
                                     std::span<const glm::dvec3> given, std::int32_t vertex);

/// How much the arms differ in length: their difference by the shorter; infinite if that is 0.
[[nodiscard]] double imbalance(const CreaseArms& arms);

/// The offset of the curve point towards the vertex before; the other is its negative, so that
/// their middle is the vertex. Along the tangent of the circle through the vertex and its
/// neighbours, as long as the arms on average, limited by the shorter one; 0 at a cusp. For
/// vertices outside regular grids.
[[nodiscard]] glm::dvec3 crease_handle(const CreaseArms& arms);

/// What a handle is to be scaled by, at least 0.02, so that it stays in a corridor along the curve:
/// in each face beside the sharp edges at the vertex it moves into the face by at most half of what
/// the corner's control point does, and an eighth of what the other edge does. A handle along a
/// reflex boundary would otherwise run through thin faces.
[[nodiscard]] double corridor_factor(const FairTopology& topology,
                                     std::span<const glm::dvec3> given, const GivenStep& step,
                                     std::span<const glm::dvec3> face_normals, std::int32_t vertex,
                                     const glm::dvec3& handle);

}  // namespace planish
