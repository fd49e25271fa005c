#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// Where a mesh itself is folded: edges whose two faces turn by more than kFoldedEdgeDegrees. No
/// smooth surface through the vertices follows both faces of such an edge.
struct FoldedEdges {
  std::int64_t count = 0;
  double area = 0;                      ///< of the faces at such edges, a share of the mesh's
  std::int32_t first_face = -1;         ///< the lowest of them; -1: none
  std::vector<std::uint8_t> is_beside;  ///< one per face: 1 where an edge of it is one
};

inline constexpr double kFoldedEdgeDegrees = 120;

/// Faces without area turn nowhere; of edges with more than two faces the first two count.
[[nodiscard]] FoldedEdges folded_edges(const PolygonMesh& mesh);

/// The same on all threads, of a mesh whose faces are those of `topology`.
[[nodiscard]] FoldedEdges folded_edges(const PolygonMesh& mesh, const MeshTopology& topology);

/// Closed parts whose faces look into them.
struct InsideOutParts {
  std::int64_t count = 0;
  std::int32_t first_face = -1;  ///< the first face of the first of them
};

/// Of a mesh that passes check(), of `component_count` parts as statistics() counts them. A part in
/// the box of another closed one may be its void, and is none of them; nor is one that takes next
/// to no room.
[[nodiscard]] InsideOutParts inside_out_parts(const PolygonMesh& mesh, const MeshTopology& topology,
                                              std::int64_t component_count);

/// One flag a face: whether it is a hole. Throws Error{UnusableMesh} for a hole that is no face.
[[nodiscard]] std::vector<std::uint8_t> hole_flags(const PolygonMesh& mesh);

/// A mesh without the vertices that no face names.
struct UsedMesh {
  PolygonMesh mesh;
  std::vector<std::int32_t> vertices;  ///< the original index of each vertex, ascending
};

/// Indices of faces and creases must be in range. Corner tags of unused vertices are dropped.
[[nodiscard]] UsedMesh without_unused_vertices(const PolygonMesh& mesh);

/// The parts of a mesh that touch at no vertex: what repair has separated stays one part.
struct MeshParts {
  std::vector<std::int32_t> of_vertex;  ///< -1: of no face
  std::int32_t count = 0;               ///< numbered by their first faces

  /// One per face.
  [[nodiscard]] std::vector<std::int32_t> of_faces(const PolygonMesh& mesh) const;
};
[[nodiscard]] MeshParts mesh_parts(const PolygonMesh& mesh);

/// Faces by what edges join: parts that touch at a vertex alone are two.
struct FaceComponents {
  std::vector<std::int32_t> of_face;
  std::int32_t count = 0;  ///< numbered by their first faces
};
[[nodiscard]] FaceComponents face_components(const MeshTopology& topology);

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
