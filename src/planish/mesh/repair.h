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

}  // namespace planish
