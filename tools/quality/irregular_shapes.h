#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "planish/mesh/polygon_mesh.h"

namespace planish::quality {

/// Meshes of uneven triangles, as scanning, simplifying and Delaunay's criterion leave them. The
/// same mesh for the same seed everywhere.

/// Random directions, connected as on the unit sphere, each at the place that `map` gives it.
[[nodiscard]] PolygonMesh hull_of_directions(
    std::int32_t count, std::uint32_t seed,
    const std::function<glm::dvec3(const glm::dvec3&)>& map);

/// Random points of the unit disc, `rim` of them on its rim, triangulated there, each at the place
/// that `map` gives it. Open: one boundary loop.
[[nodiscard]] PolygonMesh sheet_over_disc(std::int32_t inner, std::int32_t rim, std::uint32_t seed,
                                          const std::function<glm::dvec3(const glm::dvec2&)>& map);

/// Random points of the torus around the z axis, triangulated in its unrolled plane.
[[nodiscard]] PolygonMesh uneven_torus(std::int32_t count, std::uint32_t seed, double radius,
                                       double tube_radius);

/// A tube around the trefoil knot, `along` x `around` quads.
[[nodiscard]] PolygonMesh knot(std::int32_t along, std::int32_t around);

/// A mesh in few triangles: every vertex stays within that fraction of its diagonal.
[[nodiscard]] PolygonMesh simplified_within(const PolygonMesh& dense, double tolerance);

}  // namespace planish::quality
