#pragma once

#include <cstdint>
#include <vector>

#include "planish/mesh/polygon_mesh.h"
#include "planish/surface/level_faces.h"
#include "planish/surface/surface_mesh.h"

namespace planish {

/// One split of a page's surface: what its new vertices lie between, in their order.
struct PageSplit {
  /// Edges of the coarser level whose point is their own on this face's side although another face
  /// has an edge between the same vertices: a lone crease, whose two sides have their own normals.
  /// Places in the list of all corners, each the first of its edge; ascending.
  std::vector<std::int32_t> cuts;
  std::vector<std::int32_t> parent_offsets{0};  ///< one more than there are new vertices
  std::vector<std::int32_t> parents;            ///< vertices of the coarser level
};

/// The vertices of a tessellation in the order of a page, which stores no index above level 0: the
/// mesh's own vertices, their copies along sharp edges, then for each level one vertex a face and
/// one an edge, in the order in which a walk over the coarser level's faces meets them (with
/// triangles only the edges). A level's vertices are the first ones of the next.
struct PageOrder {
  std::vector<std::int32_t> rows;     ///< of each page vertex: its place in the surface
  std::vector<std::int32_t> sources;  ///< of each vertex of level 0: the mesh's vertex
  LevelFaces faces;                   ///< of level 0, in page vertices
  std::vector<PageSplit> splits;      ///< one for each level from 1 on
  std::vector<std::size_t> counts;    ///< vertices of each level
  bool triangles = false;             ///< of Loop
};

/// The order of a surface that was refined from `mesh`.
[[nodiscard]] PageOrder page_order(const SurfaceMesh& surface, const PolygonMesh& mesh);

/// The same of its texture coordinates, which every corner has: `rows` are places among them, and
/// seams are where sharp edges are else.
[[nodiscard]] PageOrder texture_order(const SurfaceMesh& surface, const PolygonMesh& mesh);

}  // namespace planish
