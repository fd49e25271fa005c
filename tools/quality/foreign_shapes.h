#pragma once

#include <cstdint>

#include "planish/mesh/polygon_mesh.h"

namespace planish::quality {

/// Meshes of the kinds that came out worst of other programs' files: results of booleans, sheets
/// that touch, scans with holes. Each is drawn from its seed, the same on every machine, and passes
/// check().

/// Closed parts that cross each other, with slivers around hubs of `sides` faces.
[[nodiscard]] PolygonMesh crossing_parts(std::int32_t sides, std::uint32_t seed);
/// Tori that stand on each other along a ring of edges with four faces, as repair() separates them.
[[nodiscard]] PolygonMesh touching_tori(std::int32_t around, std::int32_t count,
                                        std::uint32_t seed);
/// Bent patches of one to six faces that share nothing, strewn over a sphere.
[[nodiscard]] PolygonMesh loose_sheets(std::int32_t count, std::uint32_t seed);
/// Few and large polygons, of which some are pinched between opposite corners.
[[nodiscard]] PolygonMesh pinched_polygons(std::int32_t count, std::uint32_t seed);
/// Triangles through noisy points of a bumpy sphere, with gaps that were out of the scanner's
/// sight.
[[nodiscard]] PolygonMesh holed_scan(std::int32_t points, std::uint32_t seed);

}  // namespace planish::quality
