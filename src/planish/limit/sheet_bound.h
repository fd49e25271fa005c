#pragma once

#include <array>
#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "planish/limit/bezier_net.h"
#include "planish/patches/patch_form.h"

namespace planish {

/// A part of a polynomial as a sheet over the plane that touches it in its middle, about a point:
/// what tells how near the point it comes, however long and thin it is and however aslant its
/// parameters run. (The square distance by parameters has a valley there that bends, and is convex
/// in no region wider than the valley.)
class SheetBound {
 public:
  SheetBound(const BezierNet& net, const glm::dvec3& point);

  /// No place of the part is nearer to the point, but for rounding: by a box that lies along it.
  [[nodiscard]] double least_distance() const;
  /// Whether the part, continued by half its size on all sides, has one place at most where the
  /// distance falls no further, and none of the part is nearer than this. By the heights over the
  /// plane: the square distance is convex over a convex part of the plane that holds the part.
  [[nodiscard]] bool has_one_nearest();
  /// Whether a place of the continued part, relative to the point, lies over that convex part.
  /// Asked after has_one_nearest().
  [[nodiscard]] bool is_over_convex_part(const glm::dvec3& place) const;
  /// The square distance of no place of the part is less, by that of one of it, relative to the
  /// point, and how it rises and falls from there. Asked after has_one_nearest(), too.
  [[nodiscard]] double least_square(const PatchPoint& place) const;

 private:
  BezierNet net_;    // along axes_, about the point
  glm::dmat3 axes_;  // its columns: along the part, across it, off it
  glm::dvec2 middle_{0.0};
  std::array<glm::dvec2, 2> to_parameters_{};  // rows: of places of the plane
  double reach_ = 0;  // of the convex part from the middle, in parameters of the continued part
};

}  // namespace planish
