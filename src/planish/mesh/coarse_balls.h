#pragma once

#include <glm/vec3.hpp>
#include <span>

#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// Whether every connected part of a mesh may be meant as a ball, as a cube may: its edges turn
/// alike, the sharpest by at most 1.2 times what the flattest does, and from the mean of its
/// vertices the farthest of them is about three times as far as the nearest face's plane at most,
/// as in a tetrahedron. Boxes with a side far longer than others are none, nor are prisms, pyramids
/// and houses. `mesh` passes check() and uses all its vertices; `areas`: face_areas().
[[nodiscard]] bool are_coarse_balls(const PolygonMesh& mesh, const MeshTopology& topology,
                                    std::span<const glm::dvec3> areas);

}  // namespace planish
