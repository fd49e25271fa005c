#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/fair/fair_topology.h"
#include "planish/fair/vertex_frame.h"

namespace planish {

/// The ring of one vertex projected to its tangent plane, relative to the vertex. Corner i of the
/// ring lies in the wedge from its edge next[i] counter-clockwise to its edge previous[i].
/// Reused from vertex to vertex.
struct PlanarRing {
  /// A point of the plane as along_next * next + along_previous * previous.
  struct Wedge {
    double along_next, along_previous;
    bool valid;  ///< the wedge opens counter-clockwise, by more than a sliver
  };

  std::int32_t count = 0;
  std::vector<glm::dvec2> next, previous;
  std::vector<glm::dvec2> offsets;  ///< of the control points
  std::vector<Wedge> wedges;        ///< of `offsets`
  glm::dvec2 mean{0.0};             ///< of `offsets`
};

/// The wedge coordinates of `point` between two edges.
[[nodiscard]] PlanarRing::Wedge wedge_of(const glm::dvec2& point, const glm::dvec2& next,
                                         const glm::dvec2& previous);

/// How far a wedge is to be trusted: 0 where it is not valid, 1 from twice the sliver's angle on.
[[nodiscard]] double wedge_share(const glm::dvec2& next, const glm::dvec2& previous);

/// Fills `ring` with these corners around a vertex.
void project_ring(std::span<const glm::dvec3> given, std::span<const glm::dvec3> corner_offsets,
                  std::int32_t vertex, const FairTopology::Ring& corners, const VertexFrame& frame,
                  PlanarRing& ring);

/// How far the mean of the control points lies out of balance: the largest ratio of the mean's
/// wedge coordinates to a control point's. Below 1, moving all control points by it leaves each in
/// its wedge. Infinite where a control point is not safely inside its own wedge. Invariant under
/// affine maps of the plane.
[[nodiscard]] double imbalance(const PlanarRing& ring);

}  // namespace planish
