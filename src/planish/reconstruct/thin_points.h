#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "planish/reconstruct/ordered_points.h"

namespace planish {

/// Chooses points one by one, in the order of `asked` (indices of `points`; else of all of them),
/// that are no nearer than `radius` to one chosen before nor to one of `samples`: a sampling
/// without gaps, none of whose points crowd. Time grows with their number and memory with the
/// number of those chosen.
/// Source: R. L. Cook, "Stochastic Sampling in Computer Graphics", 1986 (Poisson disks by dart
/// throwing).
[[nodiscard]] std::vector<std::int32_t> thin_points(
    const OrderedPoints& points, std::optional<std::span<const std::int32_t>> asked, double radius,
    std::span<const std::int32_t> samples);

}  // namespace planish
