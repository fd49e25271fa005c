#pragma once

#include <span>

#include "planish/mesh/polygon_mesh.h"
#include "planish/mesh/prepared_mesh.h"

namespace planish {

/// Sets tags of a mesh, or takes them away where the sharpness is 0. `prepared` is of its faces.
/// Throws Error{InvalidArgument} for an edge or vertex that is not there, and for a sharpness that
/// is neither 0 nor kInfiniteSharpness.
void tag_sharp(const PreparedMesh& prepared, std::span<const CreaseEdge> edges,
               std::span<const CornerVertex> corners, PolygonMesh& mesh);

}  // namespace planish
