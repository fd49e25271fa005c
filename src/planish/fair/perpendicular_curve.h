#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

#include "planish/fair/fair_topology.h"
#include "planish/fair/perpendicular_polygon.h"
#include "planish/fair/plane_lean.h"

namespace planish {

/// What stands at a vertex with sharp edges; `offsets`: the state relative to the given points,
/// changed in place.
struct CurveSite {
  const FairTopology& topology;
  std::span<const glm::dvec3> given, face_normals;
  std::span<glm::dvec3> offsets;
  const FaceHeights& heights;
  std::int32_t vertex;
  /// From the vertex to another one.
  [[nodiscard]] glm::dvec3 edge(std::int32_t other) const { return given[other] - given[vertex]; }
};

/// As build_perpendicular_polygon() at a crease or boundary vertex: in every sector a chain from
/// one curve point to the other whose parts are at right angles to the edges that they cross, the
/// sharp ones included. The curve keeps its direction there and takes the length that fits; the
/// sector's limit normal does not turn over where the curve turns by less than a right angle to
/// either side. Where a sector's edges all lie to one side the points of a half circle stand in.
/// The sector's plane leans, about the curve, so that it sees all faces if any does; by how much is
/// chosen where `lean` is not (plane_lean.h).
void build_perpendicular_crease(const CurveSite& site, glm::vec2& lean,
                                PerpendicularScratch& scratch);

/// The same at a corner, where every face has its own plane: the polygon around a circle. Where the
/// sharp edges on both sides of a sector meet or cross, as at the tip of a slit, they are drawn
/// apart, where that turns fewer faces back: which sectors is chosen where `lean` is not.
void build_perpendicular_corner(const CurveSite& site, glm::vec2& lean);

/// Scales all control points of the vertex, those on its curves too.
void scale_curve_vertex(const CurveSite& site, double factor);

/// Least cosine between the limit normals of a crease or boundary vertex's sectors and their faces.
[[nodiscard]] double least_sector_cosine(const FairTopology& topology,
                                         std::span<const glm::dvec3> face_normals,
                                         std::span<const glm::dvec3> offsets, std::int32_t vertex);

/// At a corner: the largest part of a face's way from the vertex to its opposite side that the next
/// step leads its control point, which draws it towards a regular fan between the curve points.
/// Long sharp edges beside small faces lead it far out of them.
[[nodiscard]] double farthest_fan_point(const FairTopology& topology,
                                        std::span<const glm::dvec3> given,
                                        std::span<const glm::dvec3> offsets, std::int32_t vertex);

}  // namespace planish
