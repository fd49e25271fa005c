#pragma once

#include <array>
#include <cstdint>
#include <glm/trigonometric.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "planish/core/group_by.h"
#include "planish/features/find_features.h"
#include "planish/mesh/angle_between.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

[[nodiscard]] inline double degrees_between(const glm::dvec3& a, const glm::dvec3& b) {
  return glm::degrees(angle_between(a, b));
}

/// Faces in one plane, however it is cut.
struct Region {
  glm::dvec3 normal{0.0}, centre{0.0};
  double area = 0;
  double warp = 0;   ///< degrees by which it is bent, as its vertices are off its plane
  double share = 0;  ///< of its connected part's size: the root of the areas' ratio
  /// 1 to 0: how much it may be a facet of a smooth surface; 0 where so few as large as it make the
  /// whole part that those would be a polyhedron.
  double facet = 1;
};

/// A straight line between two regions, of one edge or several.
struct Segment {
  glm::dvec3 middle{0.0}, along{0.0};           ///< along: a unit vector, regions[0] on its left
  double length = 0, turn = 0;                  ///< turn: degrees, above 0 at ridges
  std::array<std::int32_t, 2> regions{-1, -1};  ///< the second -1 at a boundary
  bool is_tagged = false;
};

/// A mesh as regions and the lines between them.
struct RegionMap {
  std::vector<std::int32_t> region_of_face;
  std::vector<Region> regions;
  std::vector<Segment> segments;
  std::vector<std::int32_t> segment_of_edge;  ///< -1 within a region
  Groups<std::int32_t> outlines;              ///< segments by region

  /// Into a region of a segment: in its plane, across the segment.
  [[nodiscard]] glm::dvec3 inward(std::int32_t segment, std::int32_t region) const;
  /// The region on the other side; -1 at a boundary.
  [[nodiscard]] std::int32_t beyond(std::int32_t segment, std::int32_t region) const {
    const auto& [a, b] = segments[segment].regions;
    return a == region ? b : a;
  }
  /// Whether it tells of a plane, as no triangle of a smooth surface does: by more sides, or by
  /// being so large.
  [[nodiscard]] bool is_more_than_a_facet(std::int32_t region) const {
    return outlines.of(region).size() > 3 || regions[region].facet < 0.5;
  }
};

/// Without regions where the mesh is closed, has no tags, and no edge of it turns.
[[nodiscard]] RegionMap make_regions(const PolygonMesh& mesh, const MeshTopology& topology,
                                     const FeatureRules& rules);

}  // namespace planish
