#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

#include "planish/core/raw_vector.h"
#include "planish/fair/bending_rows.h"
#include "planish/fair/fair_topology.h"

namespace planish {

/// Heights, one per place of the ring arrays, that lower the bending: `steps` steps of conjugate
/// gradients from 0 on the heights whose sum over each polygon is 0. The same bits for every thread
/// count. `bending` is used up.
[[nodiscard]] RawVector<float> polish_heights(const FairTopology& topology, BendingRows&& bending,
                                              std::int32_t steps);

/// Moves the control points in `offsets` by heights along the normals, those of each polygon
/// scaled so that none moves by more than 0.3 of its distance to the vertex: beyond that the
/// linearised bending is not to be trusted.
void apply_heights(const FairTopology& topology, std::span<const glm::dvec3> normals,
                   std::span<const float> heights, std::span<glm::dvec3> offsets);

}  // namespace planish
