#pragma once

#include <algorithm>
#include <array>
#include <glm/vec3.hpp>
#include <map>
#include <span>
#include <vector>

#include "planish/patches/patch_form.h"

namespace planish {

struct PatchBox {
  glm::dvec3 low, high;

  void add(const glm::dvec3& point);
};

/// Around points; low above high where there are none.
[[nodiscard]] PatchBox box_of(std::span<const glm::dvec3> points);

/// Of a point from a box with `low` and `high`; 0 inside.
template <class Box>
[[nodiscard]] double square_distance(const Box& box, const glm::dvec3& point) {
  double sum = 0;
  for (int d = 0; d < 3; ++d) {
    const double off = std::max({box.low[d] - point[d], point[d] - box.high[d], 0.0});
    sum += off * off;
  }
  return sum;
}

/// How far patches of a form may leave the box of their control points: the box times this, about
/// its middle, holds them. 1 where no weight is negative.
[[nodiscard]] double patch_reach(const PatchForm& form);

/// Reaches of forms, made once.
class PatchReaches {
 public:
  /// For the form and those of its quarters.
  void add(const PatchForm& form);
  [[nodiscard]] double of(const PatchForm& form) const { return reaches_.at(&form); }

 private:
  std::map<const PatchForm*, double> reaches_;
};

/// Around a patch of such a reach, by its control points.
[[nodiscard]] PatchBox box_around(std::span<const glm::dvec3> points, double reach);

/// A box around a patch: that of the Bezier points of its polynomial, or of its quarters' where it
/// is none, and of the control points of those quarters that are none.
[[nodiscard]] PatchBox patch_box(const PatchForm& form, std::span<const glm::dvec3> points,
                                 const PatchReaches& reaches);

/// Boxes around a patch's quarters, at V, E1, F and E2.
[[nodiscard]] std::array<PatchBox, 4> quarter_boxes(const PatchForm& form,
                                                    std::span<const glm::dvec3> points,
                                                    const PatchReaches& reaches,
                                                    std::vector<glm::dvec3>& scratch);

}  // namespace planish
