#pragma once

#include <cstdint>

#include "planish/mesh/polygon_mesh.h"

namespace planish::test {

/// The convex hull of `count` uniformly random points of the unit sphere, which is their Delaunay
/// triangulation: rings as uneven as random sampling makes them. count >= 4.
[[nodiscard]] PolygonMesh delaunay_sphere(int count, std::uint32_t seed);

}  // namespace planish::test
