#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "planish/reconstruct/clean.h"
#include "planish/reconstruct/ordered_points.h"
#include "planish/reconstruct/ordered_tree.h"

namespace planish {

/// The rules of clean() for a cloud whose points need not all be looked at closely: what is usual
/// comes from a sample of them, and strays are looked for where it is asked for.
class PointCritic {
 public:
  /// Keeps references to the points, without duplicates, and to the options. Removes the points
  /// that are far from all others. Warns "uneven-density". Throws Error{Cancelled}.
  PointCritic(OrderedPoints& points, const CleanOptions& options);

  /// Median of the mean distances to the 6 nearest.
  [[nodiscard]] double spacing() const { return spacing_; }
  /// As measure_noise().
  [[nodiscard]] double noise() const;

  /// Of the planes that the points around those asked for scatter about: unit, either way, or 0.
  [[nodiscard]] std::vector<glm::dvec3> normals_at(std::span<const std::int32_t> asked) const;

  /// Removes those of `asked` that stray from the surface around them, and then those that these
  /// hid. That changes the indices of the points: `asked` and `followed`, both ascending, name the
  /// same points afterwards, less those removed. Throws Error{Cancelled}.
  void remove_strays(std::vector<std::int32_t>& asked, std::vector<std::int32_t>& followed);
  void remove_all_strays();

  [[nodiscard]] std::int64_t outlier_count() const { return outlier_count_; }
  [[nodiscard]] std::int64_t stray_count() const { return stray_count_; }

 private:
  void measure_sample();
  void remove_outliers(double farthest);
  [[nodiscard]] bool is_outlier(std::int32_t point, double farthest) const;
  [[nodiscard]] std::vector<std::int32_t> around(std::span<const glm::dvec3> places,
                                                 std::span<const std::int32_t> starts) const;

  OrderedPoints& points_;
  const CleanOptions& options_;
  std::optional<OrderedTree> tree_;
  double spacing_ = 0;
  bool judges_strays_ = false;
  std::int64_t outlier_count_ = 0, stray_count_ = 0;
};

}  // namespace planish
