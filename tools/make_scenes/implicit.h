#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace planish::shapes {

/// Distance functions: negative inside, zero on the surface, about the distance near it. Where a
/// function is only a bound, its comment says so. Lengths in model units.

struct Ellipsoid {
  glm::dvec3 centre, radii;
  [[nodiscard]] double operator()(const glm::dvec3& p) const;  ///< a first-order estimate
};

/// Ball swept from a to b while its radius goes from radius_a to radius_b.
struct Cone {
  glm::dvec3 a, b;
  double radius_a, radius_b;
  [[nodiscard]] double operator()(const glm::dvec3& p) const;  ///< a bound where the radii differ
};

/// The plane figure `distance` (its 2D distance) extruded to |height| <= half_height, with edges
/// rounded by `rounding`, inside the sharp body.
[[nodiscard]] double extruded(double distance, double height, double half_height, double rounding);

/// Box about the origin, edges rounded by `rounding`, inside the sharp body.
[[nodiscard]] double rounded_box(const glm::dvec3& p, const glm::dvec3& half_size, double rounding);

/// Union, intersection and difference with a fillet about `width` wide.
[[nodiscard]] double smooth_union(double a, double b, double width);
[[nodiscard]] double smooth_intersection(double a, double b, double width);
[[nodiscard]] double smooth_difference(double a, double b, double width);

/// 0 on `low`'s side, 1 on `high`'s, smooth between; either may be the greater.
[[nodiscard]] double smooth_step(double low, double high, double x);

}  // namespace planish::shapes
