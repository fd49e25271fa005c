#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/mesh/mesh_topology.h"

namespace planish {

/// The vertices at which a cone ends in a point, ascending: no tangent plane goes with all faces
/// there. Normals of the faces around go once around an axis, each at 35 degrees from it or more,
/// and turn by at most 30 from one to the next; behind the faces the cone goes on, is open or ends
/// in a sharp edge: a face there is at most half as far again from the axis. So poles of spheres
/// are none, where it would be three times as far. `face_normals`: of any length, one a face.
/// `is_sharp`: one flag an edge.
[[nodiscard]] std::vector<std::int32_t> cone_apexes(const MeshTopology& topology,
                                                    std::span<const glm::dvec3> face_normals,
                                                    std::span<const std::uint8_t> is_sharp);

}  // namespace planish
