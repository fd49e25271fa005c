#pragma once

#include <cstdint>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// For each vertex the one that it would be if edges had a length: the first of those that it is
/// joined with by edges of none to speak of. Boolean operations and bevels leave such edges, as
/// rounding does in files; the two ends have directions of their own all the same, and a surface
/// through both is pinched. They are edges
///   - whose ends coincide, and
///   - those that are not longer than kShortEdge of the bounding box's diagonal where all that they
///     join is kShortShare of the longest edge there, or less: small parts of a large model are
///     none.
/// Empty where there is none, and for a mesh with an index out of range or a position that is not
/// finite. Linear in time, on all threads where nothing is found.
[[nodiscard]] std::vector<std::int32_t> short_edge_targets(const PolygonMesh& mesh);

/// What six decimals leave of a model of a unit's size.
inline constexpr double kShortEdge = 2e-6;
inline constexpr double kShortShare = 1e-3;

}  // namespace planish
