#pragma once

#include <cstdint>

#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// Closed parts whose faces look into them.
struct InsideOutParts {
  std::int64_t count = 0;
  std::int32_t first_face = -1;  ///< the first face of the first of them
};

/// Of a mesh that passes check(), of `component_count` parts as statistics() counts them. A part in
/// the box of another closed one may be its void, and is none of them; nor is one that takes next
/// to no room.
[[nodiscard]] InsideOutParts inside_out_parts(const PolygonMesh& mesh, const MeshTopology& topology,
                                              std::int64_t component_count);

}  // namespace planish
