#pragma once

#include <glm/vec3.hpp>

#include "planish/patches/patch_form.h"

namespace planish {

/// Curvatures at a point, in one over the unit of its position (Gaussian: over its square). They
/// are positive where the surface bends away from its normal: 1/R on a sphere of radius R with
/// outward normals.
struct PointCurvature {
  double mean = 0, gaussian = 0;
  double largest = 0, smallest = 0;  ///< principal ones
  /// Unit tangents along which they are; any two where both are the same.
  glm::dvec3 largest_direction{}, smallest_direction{};
  bool is_known = false;  ///< second derivatives exist, and du and dv are not parallel
};

[[nodiscard]] PointCurvature curvature_of(const PatchPoint& point);

}  // namespace planish
