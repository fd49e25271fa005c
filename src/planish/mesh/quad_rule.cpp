#include "planish/mesh/quad_rule.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace planish {

QuadRule::QuadRule(const PairOptions& options)
    : least_cosine_(std::cos(options.largest_turn * (std::numbers::pi / 180) + kAsGood)),
      largest_angle_(options.largest_angle * (std::numbers::pi / 180) + kAsGood),
      widest_(std::tan(largest_angle_ - std::numbers::pi / 2)) {}

// Tangents tell the corners whose angle counts.
std::optional<double> QuadRule::badness_of(std::span<const glm::dvec3> positions,
                                           const std::array<std::int32_t, 4>& quad) const {
  constexpr double kRounding = 1e-9;
  const auto place = [&](std::size_t i) -> const glm::dvec3& { return positions[quad[i % 4]]; };
  const glm::dvec3 diagonal = place(2) - place(0);
  const glm::dvec3 n0 = glm::cross(place(1) - place(0), diagonal);
  const glm::dvec3 n1 = glm::cross(diagonal, place(3) - place(0));
  const double lengths = glm::length(n0) * glm::length(n1);
  if (!(lengths > 0) || glm::dot(n0, n1) < lengths * least_cosine_) return std::nullopt;
  const glm::dvec3 normal = n0 + n1;
  // The tangents are those of the deviations: above 0 of wide corners.
  std::array<double, 4> sines, cosines, tangents;
  double steepest = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const glm::dvec3 ahead = place(i + 1) - place(i), back = place(i + 3) - place(i);
    const glm::dvec3 cross = glm::cross(ahead, back);
    if (!(glm::dot(cross, normal) > 0)) return std::nullopt;
    sines[i] = glm::length(cross);
    cosines[i] = glm::dot(ahead, back);
    tangents[i] = -cosines[i] / sines[i];
    steepest = std::max(steepest, std::abs(tangents[i]));
  }
  double worst = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const bool may_be_wide = tangents[i] >= widest_ - kRounding * (1 + std::abs(widest_));
    if (!may_be_wide && std::abs(tangents[i]) < (1 - kRounding) * steepest) continue;
    const double angle = std::atan2(sines[i], cosines[i]);
    if (angle > largest_angle_) return std::nullopt;
    worst = std::max(worst, std::abs(angle - std::numbers::pi / 2));
  }
  return worst;
}

}  // namespace planish
