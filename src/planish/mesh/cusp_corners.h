#pragma once

#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// Where a boundary turns by more than this it has a tip or the end of a slit: no smooth curve goes
/// round it with all faces on one side.
inline constexpr double kCuspDegrees = 120;
/// And where faces reach around a boundary vertex by more than this: at the end of a slit whose
/// lips lie over each other the boundary turns by less.
inline constexpr double kCuspReachDegrees = 330;

/// Tags the boundary vertices where the boundary turns by more than kCuspDegrees, or whose faces
/// reach around them by more than kCuspReachDegrees, as corners; fair surfaces fold there else. The
/// mesh must pass check().
[[nodiscard]] PolygonMesh with_cusp_corners(const PolygonMesh& mesh);

}  // namespace planish
