#pragma once

#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "planish/fair/planar_ring.h"

namespace planish {

/// The polygon of control points around a vertex in its tangent plane, built from its ring alone.
/// Reused from vertex to vertex.
struct LocalPolygon {
  std::vector<glm::dvec2> points;  ///< relative to the vertex; only nearly centred
  std::vector<double> heights;     ///< above the plane; all 0 but at regular vertices

  // Scratch.
  std::vector<glm::dvec2> targets, blended;
  std::vector<double> shares;
};

/// Moves the ring's control points so that their mean comes to the vertex and each stays in the
/// wedge of its own face: by translation where the ring is even, by positive factors where it is
/// not, of its edges where those do not balance. `rho` is imbalance(ring). Continuous in the ring.
void build_local_polygon(const PlanarRing& ring, double rho, LocalPolygon& polygon);

/// What bilinear corners add to a plane: the part of the control points' heights that no plane
/// through them explains. `heights[i]` of the ring's control points above the tangent plane.
/// Call after build_local_polygon.
void add_twist(const PlanarRing& ring, std::span<const double> heights, LocalPolygon& polygon);

}  // namespace planish
