#pragma once

#include <glm/vec2.hpp>
#include <span>

namespace planish {

/// Positive weights with sum weights[i] * points[i] = 0: those of the least sum of
/// exp(-y . point) over y, near 1 where the points' mean is near 0. False where the points do not
/// surround 0, or so narrowly that no useful weights exist; `weights` is meaningless then.
/// `weights`: one per point. Source: the maximum entropy of a distribution of given mean.
[[nodiscard]] bool balance(std::span<const glm::dvec2> points, std::span<double> weights);

}  // namespace planish
