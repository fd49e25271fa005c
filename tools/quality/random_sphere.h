#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "planish/mesh/triangles.h"

namespace planish::quality {

/// Points independent and even on the unit sphere.
[[nodiscard]] std::vector<glm::dvec3> random_sphere_points(std::int32_t count, std::uint32_t seed);

/// Their Delaunay triangulation: the convex hull, in time of the order of count squared. At least
/// four points, no four of them in a plane.
[[nodiscard]] std::vector<Triangle> delaunay_on_sphere(const std::vector<glm::dvec3>& points);

}  // namespace planish::quality
