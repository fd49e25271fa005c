#pragma once

#include <cstdint>
#include <vector>

#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// Where a mesh itself is folded: edges whose two faces turn by more than kFoldedEdgeDegrees. No
/// smooth surface through the vertices follows both faces of such an edge.
struct FoldedEdges {
  std::int64_t count = 0;
  double area = 0;                      ///< of the faces at such edges, a share of the mesh's
  std::int32_t first_face = -1;         ///< the lowest of them; -1: none
  std::vector<std::uint8_t> is_beside;  ///< one per face: 1 where an edge of it is one
};

inline constexpr double kFoldedEdgeDegrees = 120;

/// Faces without area turn nowhere; of edges with more than two faces the first two count.
[[nodiscard]] FoldedEdges folded_edges(const PolygonMesh& mesh);

/// The same on all threads, of a mesh whose faces are those of `topology`.
[[nodiscard]] FoldedEdges folded_edges(const PolygonMesh& mesh, const MeshTopology& topology);

}  // namespace planish
