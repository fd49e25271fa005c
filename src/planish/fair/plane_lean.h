#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>

#include "planish/fair/fair_topology.h"
#include "planish/fair/vertex_frame.h"

namespace planish {

/// How the planes of cured polygons lean from those of their vertices' normals: chosen once and
/// kept (FairDecisions::leans), since the best choice jumps where no direction sees all faces.
/// Radians. Smooth and dart vertices: an angle towards a direction of the tangent plane, as that
/// angle's vector along ring_direction() and left of it. Crease vertices: angles about the curve,
/// of the first and the second sector. Corners: in x bit k is set where sector k was opened.
inline constexpr float kNoLean = 0x1p30F;  ///< not chosen yet
[[nodiscard]] inline bool is_chosen(const glm::vec2& lean) { return lean.x < kNoLean; }

/// Where the edges around a smooth or dart vertex point to: the first Fourier coefficient of their
/// directions in the frame's plane, unit, turning with the ring; (1, 0) where that is 0. Where they
/// surround the vertex once it is not (README.md).
[[nodiscard]] glm::dvec2 ring_direction(const FairTopology& topology,
                                        std::span<const glm::dvec3> given, std::int32_t vertex,
                                        const VertexFrame& frame);

/// That direction and the one left of it in space, in the plane of a unit normal.
struct RingAxes {
  glm::dvec3 along, left;
};
[[nodiscard]] RingAxes ring_axes(const FairTopology& topology, std::span<const glm::dvec3> given,
                                 std::int32_t vertex, const glm::dvec3& normal);

/// The lean of a smooth or dart vertex's plane from one unit normal to another.
[[nodiscard]] glm::vec2 lean_towards(const FairTopology& topology,
                                     std::span<const glm::dvec3> given, std::int32_t vertex,
                                     const glm::dvec3& normal, const glm::dvec3& target);
/// The other way around. Continuous in the given points and the normal.
[[nodiscard]] glm::dvec3 leaning_normal(const FairTopology& topology,
                                        std::span<const glm::dvec3> given, std::int32_t vertex,
                                        const glm::dvec3& normal, const glm::vec2& lean);

}  // namespace planish
