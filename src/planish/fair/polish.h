#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/fair/bending_rows.h"
#include "planish/fair/fair_topology.h"

namespace planish {

/// Heights, one per place, that lower the bending: `steps` steps of conjugate gradients from 0 on
/// the heights whose sum over each polygon is 0. In units of `height_units`. The same bits for
/// every thread count.
[[nodiscard]] std::vector<float> polish_heights(const FairTopology& topology,
                                                const BendingRows& bending, std::int32_t steps);

/// The sum of squares that BendingRows stands for.
[[nodiscard]] double bending_energy(const FairTopology& topology, const BendingRows& bending,
                                    std::span<const float> heights);

/// Moves the control points in `offsets` by heights along the normals, those of each polygon
/// scaled so that none moves by more than 0.3 of its distance to the vertex: beyond that the
/// linearised bending is not to be trusted.
void apply_heights(const FairTopology& topology, const BendingRows& bending,
                   std::span<const glm::dvec3> normals, std::span<const float> heights,
                   std::span<glm::dvec3> offsets);

}  // namespace planish
