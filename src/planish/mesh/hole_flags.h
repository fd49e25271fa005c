#pragma once

#include <cstdint>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// One flag a face: whether it is a hole. Throws Error{UnusableMesh} for a hole that is no face.
[[nodiscard]] std::vector<std::uint8_t> hole_flags(const PolygonMesh& mesh);

}  // namespace planish
