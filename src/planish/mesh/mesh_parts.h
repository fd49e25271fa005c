#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// The parts of a mesh that touch at no vertex: what repair has separated stays one part.
struct MeshParts {
  std::vector<std::int32_t> of_vertex;  ///< -1: of no face
  std::int32_t count = 0;               ///< numbered by their first faces

  /// One per face.
  [[nodiscard]] std::vector<std::int32_t> of_faces(const PolygonMesh& mesh) const;
};
[[nodiscard]] MeshParts mesh_parts(const PolygonMesh& mesh);

/// Each part by itself: its places, faces and tagged edges.
[[nodiscard]] std::vector<PolygonMesh> meshes_of(const MeshParts& parts, const PolygonMesh& mesh);

/// Some faces of a mesh with all that rides on them; vertices keep their numbers. `is_kept`: one
/// per face. Tags at vertices of other faces alone are left out.
[[nodiscard]] PolygonMesh some_faces(const PolygonMesh& mesh,
                                     std::span<const std::uint8_t> is_kept);

/// Adds the other faces, which share no vertex with those that are there, with their tags. `to` has
/// the vertices and texture coordinates of `mesh`, or these and further ones.
void add_other_faces(PolygonMesh& to, const PolygonMesh& mesh,
                     std::span<const std::uint8_t> is_kept);

}  // namespace planish
