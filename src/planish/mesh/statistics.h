#pragma once

#include <cstdint>
#include <vector>

#include "planish/mesh/polygon_mesh.h"
#include "planish/mesh/prepared_mesh.h"

namespace planish {

/// Facts that a report states.
struct MeshStatistics {
  std::int64_t vertex_count = 0, face_count = 0, edge_count = 0, unused_vertex_count = 0;
  std::vector<std::int64_t> face_size_counts;  ///< entry n: faces with n corners
  std::vector<std::int64_t> valence_counts;    ///< entry n: used vertices with n edges
  std::int64_t boundary_loop_count = 0, component_count = 0;
  std::int64_t genus = 0;  ///< summed over components; each boundary loop counts as capped
};

/// The mesh must pass check().
[[nodiscard]] MeshStatistics statistics(const PolygonMesh& mesh);

/// The same of a mesh that is prepared.
[[nodiscard]] MeshStatistics statistics(const PreparedMesh& prepared);

}  // namespace planish
