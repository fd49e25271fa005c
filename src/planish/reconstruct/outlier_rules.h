#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <span>
#include <string_view>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/reconstruct/local_fit.h"
#include "planish/reconstruct/point_tree.h"

namespace planish {

/// Of whose mean distance spacing is the median.
inline constexpr std::size_t kSpacingNeighbours = 6;
/// How often removed points are followed by a look at those beside them: strays hide each other;
/// those that another look would find are too few to matter.
inline constexpr int kOutlierLooks = 3;

/// Whether a point strays from the surface around it: is no sample of it. Clouds with noise alone
/// lose 1 in 10,000 points by the first limit; the second leaves alone what no surface would show.
[[nodiscard]] inline bool is_stray(const LocalFit& fit, double spacing) {
  constexpr double kDeviations = 5, kSpacings = 0.2;
  return fit.distance > kDeviations * fit.others_deviation && fit.distance > kSpacings * spacing;
}

/// Takes the marks of points that are far from all others off those that are samples of a sparser
/// part of the surface: off all where more than kMostOutliers are marked, else off those that lie
/// on smooth sheets of their own, which outliers all over the space do not. `place` is asked for
/// marked ones. Warns "uneven-density". Throws Error{Cancelled}.
void spare_sparse(std::vector<std::uint8_t>& is_far,
                  const std::function<glm::dvec3(std::size_t)>& place, const Callbacks& callbacks);
/// The warning; `about` is a word before the count, or empty.
void warn_of_sparse(const Callbacks& callbacks, std::string_view about, std::int64_t count);

/// Of the nearest `count` of a point's neighbours, nearest first, or of all where they are fewer.
[[nodiscard]] inline double mean_distance(std::span<const Neighbour> others, std::size_t count) {
  const auto nearest = others.first(std::min(count, others.size()));
  double sum = 0;
  for (const Neighbour& other : nearest) sum += std::sqrt(other.squared_distance);
  return nearest.empty() ? 0 : sum / static_cast<double>(nearest.size());
}

/// The upper one of an even number; 0 of none.
[[nodiscard]] inline double median_of(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

}  // namespace planish
