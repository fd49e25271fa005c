#pragma once

#include <cstdint>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// A mesh whose faces have been cut, and what that took.
struct ConvexMesh {
  PolygonMesh mesh;
  std::vector<std::int32_t> source_faces;  ///< for each face of `mesh` the input's
  std::vector<std::int32_t> cut_faces;     ///< the input's faces that were cut; ascending
  std::vector<std::int32_t>
      concave_faces;  ///< the input's of which a part stayed concave; ascending
};

/// Faces with a corner that turns inward by more than 0.05 radians, or corners in a row that do by
/// more than 0.1 together, seen along their Newell normal; ascending. Doo-Sabin surfaces that
/// interpolate fold beside such corners, because the face rule moves their control points out of
/// the face.
[[nodiscard]] std::vector<std::int32_t> concave_faces(const PolygonMesh& mesh);

/// Cuts those faces along diagonals until no corner turns inward, and faces of more than 32 corners
/// until these lie evenly, too: a surface folds within large faces where they do not. No vertex is
/// added or moved and no diagonal runs where the mesh has an edge. Faces that cross themselves may
/// stay as they are. Those of up to 32 corners are cut by the best diagonals, larger ones by
/// convex_parts() and even_parts(), in time of the order of n log n. What rides on the mesh rides
/// on. The mesh must pass check(). Throws Error{UnusableMesh} for indices out of range.
[[nodiscard]] ConvexMesh with_convex_faces(const PolygonMesh& mesh);

}  // namespace planish
