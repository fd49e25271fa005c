#pragma once

#include "planish/mesh/polygon_mesh.h"

namespace planish::bench {

/// A mesh of triangles after `rounds` Loop subdivisions, which OpenSubdiv does. Throws
/// std::invalid_argument for other faces.
[[nodiscard]] PolygonMesh loop_subdivided(const PolygonMesh& mesh, int rounds);

}  // namespace planish::bench
