#pragma once

#include <functional>
#include <glm/vec3.hpp>

#include "planish/mesh/polygon_mesh.h"

namespace planish::shapes {

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
