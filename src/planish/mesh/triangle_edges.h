#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "planish/mesh/edge_groups.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/mesh/triangles.h"

namespace planish {

/// A half-edge is numbered 3 * triangle + corner: it runs from that corner to the next.
[[nodiscard]] constexpr std::int32_t next_half_edge(std::int32_t half_edge) {
  return half_edge % 3 == 2 ? half_edge - 2 : half_edge + 1;
}
[[nodiscard]] constexpr std::int32_t previous_half_edge(std::int32_t half_edge) {
  return half_edge % 3 == 0 ? half_edge + 2 : half_edge - 1;
}

/// The sides of triangles grouped by edge; FaceSide::corner is the half-edge.
[[nodiscard]] EdgeGroups edges_of(std::span<const Triangle> triangles, std::size_t vertex_count);

/// The half-edge on the other side of each, -1 on the boundary. No edge may have more than two
/// triangles.
[[nodiscard]] std::vector<std::int32_t> twins_of(std::span<const Triangle> triangles,
                                                 std::size_t vertex_count);

/// Quads, four corners each, cut from their first corner to their third.
[[nodiscard]] std::vector<Triangle> quads_as_triangles(std::span<const std::int32_t> corners);

/// The triangles as polygons; positions are left empty.
[[nodiscard]] PolygonMesh polygons_of(std::span<const Triangle> triangles);

}  // namespace planish
