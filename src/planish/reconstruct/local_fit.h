#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

#include "planish/reconstruct/ordered_points.h"
#include "planish/reconstruct/ordered_tree.h"
#include "planish/reconstruct/point_tree.h"

namespace planish {

/// Points that a local surface is fitted to.
inline constexpr std::int32_t kFitNeighbours = 24;

/// How a point lies in the quadratic height field, over the plane of their principal components,
/// that fits its nearest points best, itself among them. Lengths are those of the points.
struct LocalFit {
  bool stable = false;
  glm::dvec3 normal{0.0};  ///< of the plane, unit, either way; 0 where there is no fit
  glm::dvec3 offset{0.0};  ///< from the point to the field, along its plane's normal
  double deviation = 0;    ///< standard deviation of the neighbours' heights about the field
  double spread = 0;       ///< second principal variance over the first: 0 for points of a line
  /// From the field that the other neighbours alone give, and what that distance deviates by
  /// where the point is one of them; 0, 0 where the field hangs on the point.
  double distance = 0, others_deviation = 0;
};

/// To `count` points, kFitNeighbours at most.
[[nodiscard]] LocalFit fit_at(std::int32_t index, std::span<const glm::dvec3> points,
                              const PointTree& tree, std::int32_t count = kFitNeighbours);
[[nodiscard]] LocalFit fit_at(std::int32_t index, const OrderedPoints& points,
                              const OrderedTree& tree, std::int32_t count = kFitNeighbours);

}  // namespace planish
