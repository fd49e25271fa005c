#pragma once

#include <functional>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "planish/mesh/polygon_mesh.h"

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

/// Negative inside, about the distance near its zero.
using Field = std::function<double(const glm::dvec3&)>;

struct SurfaceNetsOptions {
  glm::dvec3 low, high;  ///< box that holds the surface, in lattice coordinates
  double cell = 0.05;    ///< edge of a lattice cell
  int relax_steps = 30;  ///< of even spacing on the surface
  /// Lattice coordinates to model coordinates, orientation kept: smaller cells where it shrinks.
  /// Empty: the same.
  std::function<glm::dvec3(const glm::dvec3&)> warp;
};

/// By differences over 1e-5.
[[nodiscard]] glm::dvec3 gradient(const Field& field, const glm::dvec3& p);

/// Newton along the gradient to the zero set of `field`, in steps of at most `longest_step`.
[[nodiscard]] glm::dvec3 projected(const Field& field, glm::dvec3 p, double longest_step);

/// The zero set of `field` as quads, one vertex a lattice cell that it passes, spread evenly and
/// each on the zero set within 1e-9. Two-manifold where the lattice resolves the field; the caller
/// checks. Source: Gibson, "Constrained Elastic Surface Nets", 1998.
[[nodiscard]] PolygonMesh surface_nets(const Field& field, const SurfaceNetsOptions& options);

}  // namespace planish::shapes
