#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// A mesh made usable, and what it took.
struct RepairedMesh {
  PolygonMesh mesh;
  /// For each vertex of `mesh` the input's vertex that it is or copies; the input's own come first,
  /// in their order.
  std::vector<std::int32_t> source_vertices;
  std::vector<std::int32_t> source_faces;   ///< for each face of `mesh` the input's
  std::vector<std::int32_t> changed_faces;  ///< input's faces that lost corners, were turned round,
                                            ///< name copies, or were dropped; ascending
  /// Edges of the input along which sheets were separated, as its vertices, the lower one first;
  /// ascending.
  std::vector<std::pair<std::int32_t, std::int32_t>> separated_edges;
  std::vector<Warning> changes;  ///< one for each kind of repair made
};

/// Makes any mesh with indices in range and finite positions pass check(), moving no vertex:
///   - corners that repeat their predecessor are removed; faces that still name a vertex twice, as
///     polygons with a bridge to their hole do, are cut in triangles ("keyholed-faces"); where that
///     cannot be, or fewer than three corners are left, they are dropped ("degenerate-faces"), as
///     are faces that have fewer from the start ("bare-faces") and the later of two faces with the
///     same vertices ("duplicate-faces");
///   - faces are turned round so that neighbours agree, each edge-connected component in the
///     direction that most of its faces have ("turned-faces");
///   - along edges with three or more faces, or whose faces cannot be made to agree (a Moebius
///     strip), the faces are separated: each side gets vertices of its own, a boundary there
///     ("non-manifold-edges"); all vertices there become corners, so that the sheets touch along
///     the straight edges;
///   - vertices with several fans of faces get one copy for each ("non-manifold-vertices");
///   - tags that name no edge or used vertex or have no sharpness are dropped ("unknown-tags"), as
///     are holes that are no face ("unknown-holes").
/// A mesh without problems comes back as it was. Throws Error{UnusableMesh} when an index is out
/// of range, an attribute has another size than what it belongs to, a position is not finite, or no
/// face is left.
[[nodiscard]] RepairedMesh repair(const PolygonMesh& mesh);

/// Fractions of the diagonal that weld_vertices() takes: 0, or 1e-12 to less than 0.1.
[[nodiscard]] constexpr bool can_weld_within(double fraction) {
  return fraction == 0 || (fraction >= 1e-12 && fraction < 0.1);
}

/// A mesh with fewer vertices, and where they come from.
struct WeldedMesh {
  PolygonMesh mesh;
  std::vector<std::int32_t> source_vertices;  ///< for each vertex the input's; empty: none welded
  std::int64_t welded_count = 0;              ///< vertices that became another one
  std::int32_t first_welded = -1;             ///< the first of them in the input
};

/// Gives faces one vertex where several lie within `fraction` of the bounding box's diagonal of
/// each other; 0 asks for equal positions. In the order of the vertices, each becomes the nearest
/// earlier one that stays, if that is within reach; so no vertex moves farther, those that stay are
/// farther apart, and time is linear. Vertices of no face are left alone. Colours are those of the
/// vertices that stay; creases between vertices that became one go. Faces may name a vertex twice
/// or repeat another one then, which repair() mends. A mesh whose positions, indices or number of
/// colours are unusable comes back as it was, for check(). Throws Error{InvalidArgument} for
/// another fraction than those above.
[[nodiscard]] WeldedMesh weld_vertices(PolygonMesh&& mesh, double fraction);

/// The same along edges that have no length to speak of, as boolean operations and bevels leave
/// them (see short_edge_targets()); nowhere if no face would be left.
[[nodiscard]] WeldedMesh weld_short_edges(PolygonMesh&& mesh);

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
