#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/mesh/triangles.h"

namespace planish {

/// Of a mesh's largest component, in triangles: smaller ones are scraps beside it.
[[nodiscard]] constexpr std::int64_t least_part(std::int64_t largest) { return largest / 50; }

/// Triangles that reach far beyond the spacing of the points around and do not close the gap that
/// they are in: flaps over a bay of an open sheet's rim, strips across a hole or between two
/// sheets. 1 for each of them, 0 for others. A patch of them counts as open where 0.2 of its rim is
/// boundary; one that closes a gap, such as a flat face of a part of which only the edges were
/// sampled, is none, and neither is one that holds what would be a scrap without it. Every vertex
/// keeps a triangle. No edge may have more than two.
[[nodiscard]] std::vector<std::uint8_t> open_bridges(std::span<const glm::dvec3> positions,
                                                     std::span<const Triangle> triangles);

}  // namespace planish
