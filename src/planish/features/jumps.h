#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "planish/features/find_features.h"
#include "planish/features/regions.h"

namespace planish {

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
