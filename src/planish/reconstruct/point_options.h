#pragma once

#include <vector>

#include "planish/core/option.h"
#include "planish/reconstruct/reconstruct.h"

namespace planish {

using PointOption = Option<ReconstructOptions>;

/// How points become a mesh: everything that can be set, one row each.
[[nodiscard]] const std::vector<PointOption>& point_option_table();

}  // namespace planish
