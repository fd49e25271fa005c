#pragma once

#include <cstdint>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// Fractions of the diagonal that weld_vertices() takes: 0, or 1e-12 to less than 0.1.
[[nodiscard]] constexpr bool can_weld_within(double fraction) {
  return fraction == 0 || (fraction >= 1e-12 && fraction < 0.1);
}

/// A mesh with fewer vertices, and where they come from.
struct WeldedMesh {
  PolygonMesh mesh;
  std::vector<std::int32_t> source_vertices;  ///< for each vertex the input's; empty: none welded
  std::int64_t welded_count = 0;              ///< vertices that became another one
  std::int32_t first_welded = -1;             ///< the first of them in the input
};

/// Gives faces one vertex where several lie within `fraction` of the bounding box's diagonal of
/// each other; 0 asks for equal positions. In the order of the vertices, each becomes the nearest
/// earlier one that stays, if that is within reach; so no vertex moves farther, those that stay are
/// farther apart, and time is linear. Vertices of no face are left alone. Colours are those of the
/// vertices that stay; creases between vertices that became one go. Faces may name a vertex twice
/// or repeat another one then, which repair() mends. A mesh whose positions, indices or number of
/// colours are unusable comes back as it was, for check(). Throws Error{InvalidArgument} for
/// another fraction than those above.
[[nodiscard]] WeldedMesh weld_vertices(PolygonMesh&& mesh, double fraction);

/// The same along edges that have no length to speak of, as boolean operations and bevels leave
/// them (see short_edge_targets()); nowhere if no face would be left.
[[nodiscard]] WeldedMesh weld_short_edges(PolygonMesh&& mesh);

}  // namespace planish
