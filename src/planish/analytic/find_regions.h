#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/analytic/analytic_surface.h"
#include "planish/mesh/mesh_topology.h"

namespace planish {

/// Faces of a mesh, joined by edges, whose vertices lie on one surface.
struct AnalyticRegion {
  AnalyticSurface surface;
  bool is_inward = false;  ///< faces look against the surface's normals
  std::vector<std::int32_t> faces;
  double error = 0;  ///< of its vertices, from the surface: at most
  /// How deep inside the surface vertices may lie where its facets, not it, were cut by others.
  double sag = 0;

  /// Of the surface on which its faces are: 1 where its normals point to, else -1.
  [[nodiscard]] double side() const { return is_inward ? -1 : 1; }
  /// Out of the faces.
  [[nodiscard]] glm::dvec3 normal_at(const glm::dvec3& point) const {
    return side() * planish::normal_at(surface, point);
  }
};

struct AnalyticRegions {
  std::vector<AnalyticRegion> regions;
  std::vector<std::int32_t> region_of;  ///< by face, or kNoRegion
};

/// Of a face that lies on no surface that is known by name.
inline constexpr std::int32_t kNoRegion = -1;

/// Takes out regions without faces; the others are numbered anew, in their order.
void remove_empty(AnalyticRegions& regions);

/// Of an edge that no region reaches across.
inline constexpr char kGroupBorder = 2;

/// The regions of a mesh that planes, cylinders, cones, spheres and tori fit within `tolerance`,
/// each as large as it can be. `is_sharp`: one per edge: 0, or 1 where it is sharp, which surfaces
/// end at unless they are one on both sides, or kGroupBorder. A facet belongs to a curved one if
/// its normal is near those at its vertices, too. `keeps_smooth`: what is not sharp is to be
/// smooth, however far facets turn; else those that turn by 29 degrees and more and lie on nothing
/// are planes.
[[nodiscard]] AnalyticRegions find_regions(std::span<const glm::dvec3> positions,
                                           const MeshTopology& topology,
                                           std::span<const char> is_sharp, double tolerance,
                                           bool keeps_smooth);

}  // namespace planish
