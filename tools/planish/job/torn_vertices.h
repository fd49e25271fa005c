#pragma once

#include <cstdint>
#include <string>

#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish::command {

/// Vertices at open edges that lie exactly where another one does, as exporters write them that
/// give each face corners of its own.
struct TornVertices {
  std::int64_t count = 0;  ///< those that --weld 0 would take away
  std::int64_t first = -1;
};

/// Of a sound mesh whose `topology` is over all its vertices; none where no two open edges lie on
/// each other.
[[nodiscard]] TornVertices torn_vertices(const PolygonMesh& mesh, const MeshTopology& topology);

/// "12 vertices at open edges lie exactly where another one does; --weld 0 makes them one".
[[nodiscard]] std::string torn_text(const TornVertices& torn);

}  // namespace planish::command
