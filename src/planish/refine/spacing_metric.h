#pragma once

#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/mesh/mesh_topology.h"
#include "planish/refine/even_triangles.h"
#include "planish/refine/guess_surface.h"

namespace planish {

/// How densely vertices should lie, one a vertex: an edge e should have e . metric e = 1. Triangles
/// that are narrow all around, as simplification leaves them along a bend, stay so: rings are even
/// up to an affine map, which the surface follows. A mesh of triangles; `guess` is of it.
[[nodiscard]] std::vector<glm::dmat3> spacing_metrics(std::span<const glm::dvec3> positions,
                                                      const MeshTopology& topology,
                                                      const GuessSurface& guess,
                                                      const EvenTrianglesOptions& options);

}  // namespace planish
