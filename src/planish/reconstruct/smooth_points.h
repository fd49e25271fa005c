#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/reconstruct/ordered_points.h"
#include "planish/reconstruct/ordered_tree.h"

namespace planish {

/// Moves every point onto its local quadratic fit (local_fit.h), `rounds` times. Points without a
/// stable fit stay, and with `noise`, a length above 0, those beside an edge: about whose fit the
/// neighbours deviate by much more. Throws Error{Cancelled}.
[[nodiscard]] std::vector<glm::dvec3> smooth_points(std::span<const glm::dvec3> points,
                                                    std::int32_t rounds, double noise = 0,
                                                    const Callbacks& callbacks = {});
void smooth_points(OrderedPoints& points, std::int32_t rounds, double noise,
                   const Callbacks& callbacks);

/// Standard deviation of the points along the normals of the surface that they are samples of,
/// from `sample_count` of them at most, evenly picked. What a quadratic cannot follow at edges
/// grows with the number of points that are fitted, in variance as that number or faster; noise
/// does not. So the variance about fits to 24 points, taken off twice that about fits to 12, leaves
/// noise alone; 0 where nothing is left.
[[nodiscard]] double measure_noise(std::span<const glm::dvec3> points,
                                   std::int32_t sample_count = 5000);
[[nodiscard]] double measure_noise(const OrderedPoints& points, const OrderedTree& tree,
                                   std::int32_t sample_count = 5000);

}  // namespace planish
