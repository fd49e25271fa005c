#pragma once

#include <glm/vec2.hpp>
#include <span>

namespace planish {

/// Positive weights with sum weights[i] * points[i] = 0: those of the least sum of
/// exp(-y . point) over y, near 1 where the points' mean is near 0. Returns how far they are to be
/// used, 0 to 1: less than 1 where the points surround 0 only just, 0 where they do not; `weights`
/// is meaningless then. A ramp, so that a deforming mesh does not jump. `weights`: one per point.
/// Source: the maximum entropy of a distribution of given mean.
[[nodiscard]] double balance(std::span<const glm::dvec2> points, std::span<double> weights);

}  // namespace planish
