#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

#include "planish/mesh/triangles.h"

namespace planish {

/// Turns every open component of an oriented manifold over where more of its triangles face away
/// from the normals of their corners, one per position, than along them. Closed ones stay: their
/// volume says where outside is. Returns how many were turned.
std::int64_t turn_by_normals(std::span<const glm::dvec3> positions,
                             std::span<const glm::vec3> normals, std::span<Triangle> triangles);

}  // namespace planish
