#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/fair/fair_topology.h"

namespace planish {

/// Scratch memory, reused from vertex to vertex.
struct PerpendicularScratch {
  std::vector<glm::dvec2> edges, points;
  std::vector<double> weights;
};

/// Heights of faces over their longest sides; of polygons half of them, as they narrow towards it.
/// Those of large faces, at each of whose vertices they are asked for, are found once.
class FaceHeights {
 public:
  FaceHeights(const FairTopology& topology, std::span<const glm::dvec3> given);
  [[nodiscard]] double of(std::int32_t face) const;
  /// How far the control points of a perpendicular polygon may lie from the vertex: half the least
  /// height of the faces around it.
  [[nodiscard]] double size_at(std::int32_t vertex) const;

 private:
  [[nodiscard]] double measured(std::int32_t face) const;

  const FairTopology& topology_;
  std::span<const glm::dvec3> given_;
  std::vector<double> of_large_;  // by FairTopology::large_faces
};

/// Replaces the polygon around a smooth or dart vertex, in `offsets`, by a small one in the plane
/// of `normal` (unit) whose sides are at right angles to the edges that they cross, its mean 0:
/// neither edges nor faces fold beside polygons of this kind that are small enough, nor does the
/// vertex itself (see README.md). Where the edges do not surround the vertex in the plane there is
/// none, and evenly spread points on a circle stand in; in between both are blended. `size`: how
/// far the points may lie from the vertex.
void build_perpendicular_polygon(const FairTopology& topology, std::span<const glm::dvec3> given,
                                 std::int32_t vertex, const glm::dvec3& normal, double size,
                                 PerpendicularScratch& scratch, std::span<glm::dvec3> offsets);

/// How much of balanced weights is taken where they are usable so far (balanced_weights.h); the
/// rest of a polygon is that of a circle. 1 but for a short ramp.
[[nodiscard]] double chain_share(double usable);

}  // namespace planish
