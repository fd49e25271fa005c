#pragma once

#include <cstdint>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// A mesh without the vertices that no face names.
struct UsedMesh {
  PolygonMesh mesh;
  std::vector<std::int32_t> vertices;  ///< the original index of each vertex, ascending
};

/// Indices of faces and creases must be in range. Corner tags of unused vertices are dropped.
[[nodiscard]] UsedMesh without_unused_vertices(const PolygonMesh& mesh);

}  // namespace planish
