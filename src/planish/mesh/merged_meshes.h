#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// Meshes as the components of one, in their order.
struct MergedMeshes {
  PolygonMesh mesh;
  /// Entry i is where mesh i begins among vertices and faces; one more entry has their counts.
  std::vector<std::int32_t> first_vertices, first_faces;
};

/// Where only some of the meshes have uvs, colors or groups, corners of the others have none,
/// vertices are white, and faces are of a group without a name. Throws
/// Error{UnusableMesh} for indices out of range, attributes of another size than what they belong
/// to, and for more than `most` vertices, corners, faces or uvs; its element is the mesh.
[[nodiscard]] MergedMeshes merged_meshes(
    std::span<const PolygonMesh> meshes,
    std::int32_t most = std::numeric_limits<std::int32_t>::max());

}  // namespace planish
