#pragma once

#include <cstdint>
#include <string>

#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// Vertices at open edges that lie exactly where another one does, or as good as there, as
/// exporters write them that give each face corners of its own, with rounded numbers.
struct TornVertices {
  std::int64_t count = 0;  ///< those that --weld `reach` would take away
  std::int64_t first = -1;
  double reach = 0;  ///< of the diagonal; 0 where they lie there exactly
};

/// Of a sound mesh whose `topology` is over all its vertices; none where no two open edges lie on
/// each other.
[[nodiscard]] TornVertices torn_vertices(const PolygonMesh& mesh, const MeshTopology& topology);

/// "12 vertices at open edges lie exactly where another one does; --weld 0 makes them one", or
/// "12 vertices at open edges lie within 1e-05 of the diagonal of another one; --weld 1e-05 ...".
[[nodiscard]] std::string torn_text(const TornVertices& torn);

}  // namespace planish
