#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

#include "planish/fair/fair_topology.h"

namespace planish {

/// One Doo-Sabin step of `points` (one per vertex): the control point of every corner, relative to
/// the given point of its vertex. `offsets`: one per corner.
void corner_offsets(const FairTopology& topology, std::span<const glm::dvec3> given,
                    std::span<const glm::dvec3> points, std::span<glm::dvec3> offsets);

/// The same for one corner.
[[nodiscard]] glm::dvec3 corner_offset(const FairTopology& topology,
                                       std::span<const glm::dvec3> given,
                                       std::span<const glm::dvec3> points, std::int32_t corner);

}  // namespace planish
