#pragma once

#include <cstdint>
#include <vector>

#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// The boundary vertices that are corners of an outline beyond doubt, ascending, as those of a
/// sheet are: the boundary turns there by more than `corner_degrees`, in space and along the
/// surface (the faces' angles at the vertex against half a turn: the rim of an open box has no
/// corner), each neighbour on the loop goes on straight along the surface or is such a corner, at
/// most half of the loop's vertices are, or four that point outward, and three quarters of the
/// others hardly turn. Ragged
/// rims of scans and coarse round ones have none. The mesh must pass check(), use all its vertices,
/// and `topology` be its.
[[nodiscard]] std::vector<std::int32_t> outline_corners(const PolygonMesh& mesh,
                                                        const MeshTopology& topology,
                                                        double corner_degrees);

}  // namespace planish
