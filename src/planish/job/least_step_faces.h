#pragma once

#include <cstdint>

#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// A lower bound of the B-spline faces that a mesh's surface becomes, known without the surface:
/// each has four corners, and only at corners lie vertices and faces of other than four edges; and
/// none has more than face_size^2 quads of level 1.
[[nodiscard]] std::int64_t least_step_faces(const PolygonMesh& mesh, const MeshTopology& topology,
                                            std::int32_t face_size);

}  // namespace planish
