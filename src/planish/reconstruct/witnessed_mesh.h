#pragma once

#include <cstdint>
#include <vector>

#include "planish/mesh/triangles.h"

namespace planish {

/// A triangle mesh through some points of a cloud, and what it says of the others.
struct WitnessedMesh {
  std::vector<std::int32_t> vertex_points;  ///< the point at each vertex, ascending
  std::vector<Triangle> triangles;          ///< corners are indices of vertex_points
  /// The nearest triangle of each point of the cloud; -1 for those at a vertex and those beyond
  /// the tolerance of all triangles.
  std::vector<std::int32_t> carriers;
};

}  // namespace planish
