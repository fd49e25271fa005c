#pragma once

#include <array>
#include <glm/vec3.hpp>
#include <vector>

#include "planish/limit/cell_bound.h"
#include "planish/limit/limit_surface.h"
#include "planish/limit/patch_box.h"

namespace planish {

/// The quarters of a corner's patch ready to be asked often: Bezier points in the corner's
/// directions where a quarter is one polynomial. Keeps its room from corner to corner.
class PatchPieces {
 public:
  explicit PatchPieces(const LimitSurface& surface) : corner_(surface) {}

  void move_to(std::int32_t corner, const PatchReaches& reaches);
  [[nodiscard]] LimitSurface::Corner& corner() { return corner_; }
  /// As LimitSurface::Corner::at(), in unit coordinates.
  [[nodiscard]] PatchPoint at(double u, double v);
  /// Around quarter (a, b), at a + 2 b, relative to the corner's own point.
  [[nodiscard]] const PatchBox& box(std::size_t quarter) const { return boxes_[quarter]; }
  /// No point of a quarter is nearer to `point` (relative to the corner's own), by a plane across
  /// the way to its middle; 0 where that tells nothing.
  [[nodiscard]] double least_distance(std::size_t quarter, const glm::dvec3& point) const;

 private:
  LimitSurface::Corner corner_;
  bool is_polynomial_ = false;  // as a whole: whole_
  BezierNet whole_{};
  std::array<BezierNet, 4> nets_{};
  std::array<bool, 4> has_net_{};
  std::array<PatchBox, 4> boxes_{};
  std::vector<glm::dvec3> points_;
};

}  // namespace planish
