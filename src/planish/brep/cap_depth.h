#pragma once

#include <cstdint>

#include "planish/brep/cap_measure.h"
#include "planish/brep/quad_layout.h"
#include "planish/core/callbacks.h"

namespace planish {

constexpr int kDeepestCap = 12;

/// The smallest depths, to kDeepestCap, that keep the limits, with moves where they let a depth
/// be smaller. Reports step
/// "faces" from 0 to 1.
[[nodiscard]] CapDepths cap_depths(const SplineSurface& surface, const QuadLayout& layout,
                                   const CapLimits& limits, const Callbacks& callbacks);

}  // namespace planish
