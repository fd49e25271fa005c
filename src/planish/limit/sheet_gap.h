#pragma once

#include <cstdint>
#include <span>
#include <utility>

#include "planish/limit/limit_surface.h"

namespace planish {

/// How far sheets that repair() separated along edges of three or more faces are from each other
/// there: of every such edge the boundary curves over it, one of each sheet, the largest distance
/// from the first to a place on any other or back, in model coordinates. Sampled at 17 places a
/// curve, against the lines between the other's. `source_vertices`: for each vertex of the mesh the
/// one that it is or copies; `edges`: pairs of these, the lower one first, ascending, as
/// RepairedMesh has them. 0 where no sheets meet.
[[nodiscard]] double sheet_gap(const LimitSurface& surface,
                               std::span<const std::int32_t> source_vertices,
                               std::span<const std::pair<std::int32_t, std::int32_t>> edges);

}  // namespace planish
