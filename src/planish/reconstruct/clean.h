#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/core/callbacks.h"

namespace planish {

enum class OutlierRule {
  Off,
  Auto,      ///< as Distance with the defaults, without those that are a sparse part of the shape,
             ///< and points that stick out of the surface around them
  Distance,  ///< remove what is farther than `factor` medians from its neighbours
};

struct CleanOptions {
  OutlierRule outliers = OutlierRule::Auto;
  std::int32_t neighbour_count = 12;  ///< 1 to 100
  double factor = 2.0;                ///< positive
  Callbacks callbacks;
};

/// Share of points above which OutlierRule::Auto takes sparse points for a part of the shape in any
/// case; fewer where they lie on smooth sheets of their own.
inline constexpr double kMostOutliers = 0.05;

/// What is left of a cloud.
struct CleanPoints {
  std::vector<std::int32_t> kept;  ///< indices of the points that stay, ascending
  std::int64_t duplicate_count = 0;
  std::int64_t outlier_count = 0;  ///< far from all others
  std::int64_t stray_count = 0;    ///< off the surface around them
  double spacing = 0;  ///< median over the kept points of the mean distance to the 6 nearest
};

/// Removes all but the first of points at the same place, then outliers: points whose mean
/// distance to their nearest `neighbour_count` points exceeds `factor` times the median of that
/// distance; by OutlierRule::Auto then points whose distance to the quadratic fit of their
/// neighbours (local_fit.h) is above 5 of its standard deviations and 0.2 of the spacing. Throws
/// Error{InvalidArgument}, Error{Cancelled}. Warns "uneven-density".
[[nodiscard]] CleanPoints clean(std::span<const glm::dvec3> points,
                                const CleanOptions& options = {});

}  // namespace planish
