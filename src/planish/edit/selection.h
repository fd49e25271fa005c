#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/mesh/prepared_mesh.h"

namespace planish {

/// Vertices that move together, each by its share of the move.
struct Selection {
  std::vector<std::int32_t> vertices;
  std::vector<double> weights;  ///< one a vertex, 0 to 1
};

/// The vertices within `radius` of some others, by the shortest way along edges, so that a sheet
/// nearby does not come along. Weights fall smoothly from 1 there to 0 at the radius:
/// (1 - (d / radius)^2)^2. Costs what it finds. Throws Error{InvalidArgument} for a radius that is
/// not above 0 or not finite.
/// `vertices` and the result are of the mesh that was prepared, `positions` its.
[[nodiscard]] Selection select_around(const PreparedMesh& prepared,
                                      std::span<const glm::dvec3> positions,
                                      std::span<const std::int32_t> vertices, double radius);

}  // namespace planish
