#pragma once

#include <filesystem>
#include <optional>

#include "planish/mesh/polygon_mesh.h"

namespace planish::quality {

/// Facets that a peer put between the vertices of a mesh.
struct PeerSurface {
  PolygonMesh facets;
  double milliseconds = 0;  ///< without reading and writing files
};

/// manifold-3d's surface through all vertices of a closed mesh of triangles: smoothOut(180, 0) and
/// refine(n), n^2 facets a triangle, run by node. `folder`: where npm installed manifold-3d. Empty
/// where the mesh has a boundary, which it does not take. Throws std::runtime_error where node or
/// the package is missing.
[[nodiscard]] std::optional<PeerSurface> smoothed_by_manifold(const PolygonMesh& mesh, int n,
                                                              const std::filesystem::path& folder);

}  // namespace planish::quality
