#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/analytic/find_regions.h"
#include "planish/analytic/region_borders.h"
#include "planish/mesh/mesh_topology.h"

namespace planish {

/// Regions whose surfaces agree: what is parallel, at right angles, on one axis, in one plane, of
/// one radius within what the vertices tell is so exactly, surfaces that touch along a chain touch,
/// and those that meet at a vertex meet in a point. Least squares under these conditions.
struct SettledRegions {
  std::vector<char> is_tangent;  ///< by chain
};
[[nodiscard]] SettledRegions settle_surfaces(std::span<const glm::dvec3> positions,
                                             const MeshTopology& topology,
                                             const RegionBorders& borders,
                                             AnalyticRegions& regions);

/// A surface with the side of it that faces look to, 1 or -1.
struct SidedSurface {
  const AnalyticSurface* surface = nullptr;
  double side = 1;
};

/// The point that all surfaces have, near one; `touching`: pairs of them that touch there, so that
/// their normals are one. Where they leave it free (two surfaces, a chain), it stays where it is
/// along that. `reach` is set to the largest distance from them.
[[nodiscard]] glm::dvec3 common_point(const glm::dvec3& near,
                                      std::span<const SidedSurface> surfaces,
                                      std::span<const std::array<std::size_t, 2>> touching,
                                      double& reach);

/// Where two surfaces meet.
struct BorderSides {
  SidedSurface left, right;
  bool is_tangent = false;

  /// Their common_point(), of `cut` too where it is given.
  [[nodiscard]] glm::dvec3 point(const glm::dvec3& near, double& reach,
                                 const AnalyticSurface* cut = nullptr) const;
};

}  // namespace planish
