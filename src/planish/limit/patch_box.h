#pragma once

#include <glm/vec3.hpp>
#include <map>
#include <span>

#include "planish/patches/patch_form.h"

namespace planish {

struct PatchBox {
  glm::dvec3 low, high;

  void add(const glm::dvec3& point);
};

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

/// A box around a patch: that of the Bezier points of its polynomial, or of its quarters' where it
/// is none, and of the control points of those quarters that are none.
[[nodiscard]] PatchBox patch_box(const PatchForm& form, std::span<const glm::dvec3> points,
                                 const PatchReaches& reaches);

/// The nine Bezier points of a patch that is one polynomial, (i, j) at i + 3 j.
void bezier_points(const PatchForm& form, std::span<const glm::dvec3> points,
                   std::span<glm::dvec3, 9> bezier);

}  // namespace planish
