#pragma once

#include <array>
#include <cstdint>
#include <glm/trigonometric.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/core/group_by.h"
#include "planish/features/find_features.h"
#include "planish/mesh/face_geometry.h"
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

/// Without regions where the mesh is closed, has no tags, and no edge of it turns; and where none
/// has at least that share of its part.
[[nodiscard]] RegionMap make_regions(const PolygonMesh& mesh, const MeshTopology& topology,
                                     const FeatureRules& rules, double least_share = 0);

/// What the smooth surface on one side of a turn leads one to expect there, in degrees.
struct Explained {
  double turn = 0;       ///< 0 to the rules' cap
  double whole = 0;      ///< how far the surface bends there, either way, without the cap
  double spread = 0;     ///< how far the surface itself is from what was fitted
  bool is_known = true;  ///< false: nothing is there to tell; then the other side speaks for both

  /// Of a turn of the same sense, without the cap.
  [[nodiscard]] double along() const { return turn > 0 ? whole : 0; }
};

/// The jump: a turn less what both sides explain.
[[nodiscard]] double jump_of(double turn, const Explained& left, const Explained& right);

/// What a turn explains of the one before it on the same line or surface: half of it, less where
/// the way between them (`width`) is shorter than the way behind (`width_behind`), as a smooth
/// curve turns by its curvature times the half ways, and less where the way before (`width_before`)
/// is far shorter: there the surface changes.
[[nodiscard]] Explained explained_by(double turn, double turn_behind, double width,
                                     double width_behind, double width_before,
                                     const FeatureRules& rules);

/// The jumps of a mesh's segments.
class SegmentJumps {
 public:
  SegmentJumps(const RegionMap& map, const FeatureRules& rules);

  struct Jump {
    double jump = 0;   ///< degrees
    double scale = 1;  ///< degrees: where a jump begins to be a feature
  };
  /// Segments that are `is_sharp` belong to no smooth surface, and explain nothing.
  [[nodiscard]] Jump jump(std::int32_t segment, std::span<const char> is_sharp) const;

  [[nodiscard]] Explained explained(std::int32_t segment, int side,
                                    std::span<const char> is_sharp) const;

  /// Whether a region is a large plane as it stands, whatever is sharp around it. Any three places
  /// lie in a plane: triangles are told to be one where few as large make the part.
  [[nodiscard]] bool is_told(std::int32_t region) const;
  /// Whether both regions are.
  [[nodiscard]] bool is_between_planes(std::int32_t segment) const;

 private:
  // What lies across a region from a segment.
  struct Across {
    double width = 0;           // 0: nothing
    std::int32_t segment = -1;  // -1: nothing parallel
  };
  const RegionMap& map_;
  const FeatureRules& rules_;
  std::vector<std::array<Across, 2>> across_;  // by segment and side

  void look_across(std::int32_t region);
  [[nodiscard]] int side_of(std::int32_t segment, std::int32_t region) const {
    return map_.segments[segment].regions[0] == region ? 0 : 1;
  }
  [[nodiscard]] Explained explained_by_far(std::int32_t segment, int side,
                                           std::span<const char> is_sharp) const;
  [[nodiscard]] Explained fitted(std::int32_t segment, std::int32_t region,
                                 std::span<const char> is_sharp) const;
  [[nodiscard]] double bend_of(std::int32_t segment, int side,
                               std::span<const char> is_sharp) const;
  [[nodiscard]] bool is_plane(std::int32_t region) const;
};

}  // namespace planish
