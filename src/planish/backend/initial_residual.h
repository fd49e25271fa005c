#pragma once

#include <glm/vec3.hpp>
#include <span>

#include "planish/core/raw_vector.h"
#include "planish/stencil/stencil_table.h"

namespace planish {

/// given - B given, one per row: sum_j b_ij (given_i - given_j), so that rounding is relative to
/// the differences and rows need not sum to 1 to the last bit.
[[nodiscard]] RawVector<glm::dvec3> initial_residual(const SummedView& limit_masks,
                                                     std::span<const glm::dvec3> given);

/// The sums of points.
[[nodiscard]] RawVector<glm::dvec3> sums_of(const SummedView& table,
                                            std::span<const glm::dvec3> points);

}  // namespace planish
