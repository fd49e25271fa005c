#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "planish/features/find_features.h"
#include "planish/features/regions.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// Vertices, ascending, where a boundary or a line of two sharp segments jumps, or where a cone
/// ends: by the same jump as edges.
[[nodiscard]] std::vector<std::int32_t> find_corners(const PolygonMesh& mesh,
                                                     const MeshTopology& topology,
                                                     const RegionMap& map,
                                                     std::span<const char> is_sharp,
                                                     const FeatureRules& rules);

/// Of these the vertices inside the surface where a line of two sharp segments jumps.
[[nodiscard]] std::vector<std::int32_t> find_bends(const PolygonMesh& mesh,
                                                   const MeshTopology& topology,
                                                   const RegionMap& map,
                                                   std::span<const char> is_sharp,
                                                   const FeatureRules& rules);

}  // namespace planish
