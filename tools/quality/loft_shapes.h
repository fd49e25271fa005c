#pragma once

#include <cstdint>

#include "planish/mesh/polygon_mesh.h"

namespace planish::quality {

/// More meshes as other people's files hold them, drawn from their seeds.

/// Body through three rings of unlike counts, the first `sides` on a nearly flat ellipse, caps as
/// fans around a vertex of the rim: needles that wind about hubs at sharp rims.
[[nodiscard]] PolygonMesh flat_loft(std::int32_t sides, std::uint32_t seed);
/// Sheet torn to its middle, whose lips bend far apart up and down; `spokes` triangles around the
/// tear's end, in `rings`.
[[nodiscard]] PolygonMesh torn_sheet(std::int32_t spokes, std::int32_t rings, std::uint32_t seed);

}  // namespace planish::quality
