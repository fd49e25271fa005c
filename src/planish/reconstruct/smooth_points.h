#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/core/callbacks.h"

namespace planish {

/// Neighbours that a local surface is fitted to, the point itself among them.
inline constexpr std::int32_t kFitNeighbours = 24;

/// Moves every point along the normal of a quadratic height field fitted to its kFitNeighbours
/// nearest points, onto that field; `rounds` times. Points without a stable fit stay.
/// Throws Error{Cancelled}.
[[nodiscard]] std::vector<glm::dvec3> smooth_points(std::span<const glm::dvec3> points,
                                                    std::int32_t rounds,
                                                    const Callbacks& callbacks = {});

/// Standard deviation of the points about the same local fits: the median over at most
/// `sample_count` points, evenly picked. On a noise-free smooth surface it is the part that a
/// quadratic cannot follow.
[[nodiscard]] double measure_noise(std::span<const glm::dvec3> points,
                                   std::int32_t sample_count = 5000);

}  // namespace planish
