#pragma once

#include <cstdint>
#include <vector>

#include "planish/surface/surface_blocks.h"
#include "support/quad_split_oracle.h"

namespace planish::test {

/// Which of the oracle's faces and vertices are the library's, found level by level: children of a
/// matched face are tried in every order and rotation until all four limit points are close.
class LevelMatch {
 public:
  /// To be called with levels 1, 2, ... in turn, `oracle` at the same level. Reports a test
  /// failure where a face has no counterpart or a vertex two.
  void advance(const SurfaceMesh& surface, const QuadSplitOracle& oracle);

  [[nodiscard]] std::int32_t face_of(std::int32_t library_face) const {
    return faces_[library_face].face;
  }
  /// Largest distance between limit points of the latest level.
  [[nodiscard]] double worst_position() const { return worst_position_; }
  /// Largest distance between unit normals, face corner by face corner, so that each side of a
  /// crease is held against its own sector. Degenerate tangents are left out.
  [[nodiscard]] double worst_normal() const { return worst_normal_; }

 private:
  struct Match {
    std::int32_t face, rotation;
  };
  [[nodiscard]] Match find(const SurfaceMesh& surface, const QuadSplitOracle& oracle,
                           std::int64_t library_face) const;
  void compare(const SurfaceMesh& surface, const QuadSplitOracle& oracle);

  std::vector<Match> faces_;
  double worst_position_ = 0, worst_normal_ = 0;
};

}  // namespace planish::test
