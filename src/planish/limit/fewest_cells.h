#pragma once

#include <cstdint>
#include <span>

#include "planish/limit/limit_surface.h"

namespace planish {

/// About how many cells triangles within `distance` (unit coordinates) of the surface take, from
/// below: what its curvature along u and along v asks for, and a part of that, since cells may be
/// of any shape. One look at each corner. `hidden`: one flag a corner. The same bits for every
/// thread count.
[[nodiscard]] double fewest_cells(const LimitSurface& surface, std::span<const std::uint8_t> hidden,
                                  double distance);

}  // namespace planish
