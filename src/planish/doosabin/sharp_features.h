#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <unordered_map>
#include <vector>

#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/mesh/sharpness.h"

namespace planish {

/// By the number of sharp edges at the vertex: none, one, two, three or more (or tagged).
enum class VertexKind : std::uint8_t { Smooth, Dart, Crease, Corner };

/// How the surface continues in the sector between two sharp edges at a corner vertex.
enum class CornerSector : std::uint8_t { Convex, HalfPlane, Reflex };

/// The sharp edges and vertices of a mesh. A sharp edge is a boundary edge or one tagged with
/// infinite sharpness; lower sharpness counts as none.
struct SharpFeatures {
  std::vector<VertexKind> vertex_kinds;     ///< one per vertex
  std::vector<std::int32_t> sharp_of_edge;  ///< per edge of the mesh its number among the sharp, or
                                            ///< -1; empty when there is none
  std::vector<std::int32_t> corner_of_vertex;  ///< per vertex its number among corners, or -1;
                                               ///< empty when there is none
  std::vector<std::int32_t> corner_vertices;   ///< by that number
  std::int32_t sharp_edge_count = 0;
  std::int32_t interior_sharp_edge_count = 0;
  std::int32_t corner_count = 0;
  /// Sectors at corners by (vertex, sharp edge that starts the sector counter-clockwise).
  std::unordered_map<std::uint64_t, CornerSector> corner_sectors;

  [[nodiscard]] static std::uint64_t sector_key(std::int32_t vertex, std::int32_t sharp_edge) {
    return static_cast<std::uint64_t>(vertex) << 32 | static_cast<std::uint32_t>(sharp_edge);
  }
};

/// `topology` is of `mesh`. Sector angles are measured on `rest_positions`, one per vertex of the
/// mesh: fixed once, so that a deformed surface keeps its rules.
[[nodiscard]] SharpFeatures find_sharp_features(const PolygonMesh& mesh,
                                                const MeshTopology& topology,
                                                std::span<const glm::dvec3> rest_positions,
                                                const SharpFeatureOptions& options);

}  // namespace planish
