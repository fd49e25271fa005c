#pragma once

#include <cstdint>
#include <vector>

#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// From so many vertices on a mesh may be dense: level 2 of one has more than 600,000 triangles.
inline constexpr std::int64_t kDenseVertices = 20'000;
/// A face is even where it turns by less to each of its neighbours. Facets of level 1 then turn by
/// about half of that, those of level 2 by a quarter.
inline constexpr double kEvenDegrees = 20;
/// Of its area a dense mesh has so much in even faces.
inline constexpr double kDenseShare = 0.75;

/// How closely the faces of a mesh follow its surface.
struct MeshDensity {
  std::int64_t vertex_count = 0;  ///< of its faces
  /// Of its area, that of even faces; measured from kDenseVertices on, 0 below.
  double even_share = 0;
  /// Vertices were added since between those of uneven triangles, about as a split does.
  bool is_refined = false;

  [[nodiscard]] bool is_dense() const { return even_share >= kDenseShare; }
  /// How often faces are split where nobody says it: 2 times, 1 where the mesh is dense or was
  /// refined.
  [[nodiscard]] int level() const { return is_dense() || is_refined ? 1 : 2; }
};

/// `topology`: of the mesh.
[[nodiscard]] MeshDensity mesh_density(const PolygonMesh& mesh, const MeshTopology& topology);

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
