#pragma once

#include <cstdint>
#include <vector>

#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// A mesh without triangles that were flat, and what that took.
struct UnflattenedMesh {
  PolygonMesh mesh;                         ///< empty where there were none
  std::vector<std::int32_t> source_faces;   ///< for each face of `mesh` the input's
  std::vector<std::int32_t> changed_faces;  ///< the input's that went or took a vertex; ascending
  std::vector<std::int32_t> flat_faces;     ///< the input's that went; ascending
};

/// Takes out triangles whose corners lie on a line, as triangulations of polygons with a corner
/// within a side have them: they have no normal, so that no edge beside one tells a crease. The
/// face across the longest side takes the vertex within it, and is cut there if it is a triangle;
/// at a boundary nothing does. No vertex moves, and where a triangle was no longer flat than
/// short_edge_targets() says of edges the shape is the same. Stay do triangles whose longest side
/// is tagged or leads to a hole, where an edge would be there twice, and all but one of those that
/// share a face: call it again. `topology` is the mesh's, whatever its vertices are called;
/// `adds_uvs`: a vertex may get texture coordinates of its own in the face that takes it.
[[nodiscard]] UnflattenedMesh without_flat_triangles(const PolygonMesh& mesh,
                                                     const MeshTopology& topology, bool adds_uvs);

}  // namespace planish
