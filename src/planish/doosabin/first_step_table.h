#pragma once

#include "planish/core/range.h"
#include "planish/doosabin/subdivision.h"
#include "planish/stencil/stencil_table.h"

namespace planish {

/// Rows of the state of level 1 from control points: one Doo-Sabin step.
[[nodiscard]] StencilTable first_step_table(const Subdivision& subdivision, RowRange rows);

}  // namespace planish
