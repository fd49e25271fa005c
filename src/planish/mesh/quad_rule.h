#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>

#include "planish/mesh/pair_triangles.h"

namespace planish {

/// Radians: angles that differ by less are the same; rounding does not decide between them.
inline constexpr double kAsGood = 1e-6;

/// What makes a good quad of two triangles.
class QuadRule {
 public:
  explicit QuadRule(const PairOptions& options);

  /// Largest deviation of a corner from a right angle, in radians; none for a quad that may not be.
  [[nodiscard]] std::optional<double> badness_of(std::span<const glm::dvec3> positions,
                                                 const std::array<std::int32_t, 4>& quad) const;

 private:
  double least_cosine_, largest_angle_;
  double widest_;  // the tangent of that angle's deviation from a right one
};

}  // namespace planish
