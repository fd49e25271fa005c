#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <vector>

#include "planish/fair/fair_net.h"
#include "planish/fair/fair_topology.h"

namespace planish {

/// The ellipse of evenly spread points around a smooth or dart vertex whose sides cross all edges
/// best. A few steps make such an ellipse of any polygon; where a hub's edges crowd, that of the
/// perpendicular polygon may run along edges that leave its plane, or backwards (README.md). Chosen
/// once and kept (FairDecisions::ellipses): point i lies at (x cos + y sin, z cos + w sin) of its
/// angle 2 pi i / n, along ring_direction() and left of it, the farthest point at distance 1.
/// `plane`: the unit normal that the polygon has; `face_normals` are unit. All zero where no
/// ellipse in that plane crosses all edges the right way.
[[nodiscard]] glm::vec4 hub_ellipse(const FairTopology& topology, std::span<const glm::dvec3> given,
                                    std::span<const glm::dvec3> face_normals, std::int32_t vertex,
                                    const glm::dvec3& plane);

/// Whether there is one.
[[nodiscard]] inline bool is_ellipse(const glm::vec4& ellipse) {
  return ellipse != glm::vec4(0.0F);
}

/// Chooses the ellipses of flagged vertices and others of their faces, where the cure changed them
/// and they have none yet; 1 per vertex that has got one.
[[nodiscard]] std::vector<std::uint8_t> choose_ellipses(const FairTopology& topology,
                                                        std::span<const glm::dvec3> given,
                                                        std::span<const std::uint8_t> flagged,
                                                        FairDecisions& decisions);

/// Writes the polygon's control points relative to the vertex, the farthest at `size`.
void build_hub_ellipse(const FairTopology& topology, std::span<const glm::dvec3> given,
                       std::int32_t vertex, const glm::dvec3& plane, const glm::vec4& ellipse,
                       double size, std::span<glm::dvec3> offsets);

}  // namespace planish
