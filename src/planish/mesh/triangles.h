#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/core/callbacks.h"

namespace planish {

/// Vertex indices, counter-clockwise seen from outside.
using Triangle = std::array<std::int32_t, 3>;

/// Makes triangles whose corners are points of a cloud without duplicates. Each triangle names
/// three different points; their winding may differ from one to the next. Throws planish::Error.
using Mesher =
    std::function<std::vector<Triangle>(std::span<const glm::dvec3>, const Callbacks& callbacks)>;

}  // namespace planish
