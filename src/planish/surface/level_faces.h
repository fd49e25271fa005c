#pragma once

#include <opensubdiv/far/topologyRefiner.h>

#include <cstdint>
#include <span>
#include <vector>

#include "planish/mesh/polygon_mesh.h"
#include "planish/solve/stencil_builder.h"
#include "planish/surface/surface_blocks.h"

namespace planish {

/// Gives a connected surface the attributes of the mesh it was refined from: texture coordinates
/// and colours linearly (given corners and vertices keep theirs, seams stay seams), groups by face.
/// `refiner` is refined to the surface's level at least.
void carry_attributes(const PolygonMesh& mesh, const OpenSubdiv::Far::TopologyRefiner& refiner,
                      const SectorRows& rows, SurfaceMesh& surface);

/// Faces of the surface, holes in it included, that stem from one face of the mesh. They follow one
/// another in the order of the mesh's faces.
[[nodiscard]] std::int64_t descendant_count(const SurfaceMesh& surface, std::int32_t face_size);

/// Takes the descendants of the mesh's hole faces out of a surface, and the vertices
/// that no other face names.
void remove_holes(const PolygonMesh& mesh, SurfaceMesh& surface);

/// The faces of one level of a tessellation; corners name the tessellation's own vertices.
struct LevelFaces {
  std::vector<std::int32_t> offsets{0};  ///< face_count + 1
  std::vector<std::int32_t> vertices;    ///< all corners

  [[nodiscard]] std::size_t face_count() const { return offsets.size() - 1; }
  [[nodiscard]] std::span<const std::int32_t> face(std::size_t index) const {
    return {vertices.data() + offsets[index],
            static_cast<std::size_t>(offsets[index + 1] - offsets[index])};
  }
};

/// The faces of levels 0 to surface.level, read off the faces of the last: every face of a level is
/// followed by its children in the order of its corners. Level 0 are the faces of `mesh`, which the
/// surface was refined from, without its holes; where a vertex has several normals its corners name
/// different copies. Children lie as child_corners() says.
[[nodiscard]] std::vector<LevelFaces> level_faces(const SurfaceMesh& surface,
                                                  const PolygonMesh& mesh);

/// Where the vertices of child `k` of a face lie among the child's own corners.
struct ChildCorners {
  int corner;  ///< corner k of the face
  int edge;    ///< the point of the edge from corner k to the next
  int middle;  ///< the point of the face; -1 where faces are triangles (Loop)
};
[[nodiscard]] ChildCorners child_corners(std::size_t face_size, std::size_t child_size, int k);

/// The face of the mesh that each face of the surface descends from.
[[nodiscard]] std::vector<std::int32_t> ancestor_faces(const SurfaceMesh& surface,
                                                       const PolygonMesh& mesh);

}  // namespace planish
