#pragma once

#include "planish/mesh/polygon_mesh.h"
#include "planish/surface/surface_mesh.h"

namespace planish {

/// Area of `surface` whose limit normal is turned by more than 90 degrees from the normal of the
/// input face it came from, as a fraction of the whole area; each face's area is shared among its
/// corners. `input` is the mesh that was fitted; any level.
[[nodiscard]] double folded_area(const SurfaceMesh& surface, const PolygonMesh& input);

}  // namespace planish
