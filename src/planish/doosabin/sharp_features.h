#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// What an untagged open boundary is.
enum class BoundaryRule {
  Edge,           ///< creases throughout
  EdgeAndCorner,  ///< and boundary vertices with one face are corners
};

enum class VertexKind : std::uint8_t { Smooth, Dart, Crease, Corner, Unused };

/// How a sector at a corner vertex is continued; fixed once from the rest pose.
enum class CornerSector : std::uint8_t { Convex, HalfPlane, Reflex };

}  // namespace planish
