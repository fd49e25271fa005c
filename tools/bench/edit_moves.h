#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish::bench {

// What the group `edit` moves, on the CPU and on devices.
inline constexpr std::size_t kManyMoves = 1000;
inline constexpr double kWayOfEdit = 0.01;  ///< of the diagonal

/// This way or the other by lot: all vertices by one way would leave nothing to solve.
[[nodiscard]] glm::dvec3 way_of(std::int32_t vertex, double way);

/// The kManyMoves vertices nearest to a vertex, that one among them.
[[nodiscard]] std::vector<std::int32_t> near_vertices(const PolygonMesh& mesh, std::int32_t vertex);

/// kManyMoves vertices all over the mesh.
[[nodiscard]] std::vector<std::int32_t> scattered_vertices(const PolygonMesh& mesh);

}  // namespace planish::bench
