#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish {

enum class MeshProblemKind {
  NoFaces,
  NonFinitePosition,       ///< element: vertex
  IndexOutOfRange,         ///< element: face
  FaceTooSmall,            ///< element: face with fewer than 3 corners
  RepeatedCorner,          ///< element: face that names a vertex twice
  DuplicateFace,           ///< element: the later face of two with the same vertices
  InconsistentWinding,     ///< element: face that runs along an edge in its neighbour's direction
  NonManifoldEdge,         ///< element: a face at an edge with three or more faces
  NonManifoldVertex,       ///< element: vertex with more than one fan of faces
  UnknownCreaseEdge,       ///< element: index of a crease that is no edge of the mesh
  UnknownCornerVertex,     ///< element: index of a corner that is no used vertex
  ValenceTooHigh,          ///< element: vertex or face above OpenSubdiv's limit of 65535
  TooLarge,                ///< more corners than 32-bit stencil tables can address
};

/// Stable name, e.g. "non-manifold-edge"; used in reports.
[[nodiscard]] std::string_view name_of(MeshProblemKind kind);

struct MeshProblem {
  MeshProblemKind kind;
  std::int64_t element;  ///< 0-based index; see MeshProblemKind
  std::string message;   ///< "face 12 names vertex 4031 of 4030", 0-based indices
};

/// Every reason why no surface can be made of the mesh, in the order of the kinds above, then of
/// the elements. Empty: the mesh can be refined. Unused vertices are no problem. Never throws but
/// for std::bad_alloc; positions, offsets and indices may hold anything.
[[nodiscard]] std::vector<MeshProblem> check(const PolygonMesh& mesh);

/// Throws Error{UnusableMesh} naming `name` and the first ten problems; nothing when there is none.
void require_usable(const PolygonMesh& mesh, std::string_view name);

/// Facts that a report states. The mesh must pass check().
struct MeshStatistics {
  std::int64_t vertex_count, face_count, edge_count, unused_vertex_count;
  std::vector<std::int64_t> face_size_counts;  ///< entry n: faces with n corners
  std::vector<std::int64_t> valence_counts;    ///< entry n: used vertices with n edges
  std::int64_t boundary_loop_count, component_count;
  std::int64_t genus;  ///< summed over components; each boundary loop counts as capped
};
[[nodiscard]] MeshStatistics statistics(const PolygonMesh& mesh);

}  // namespace planish
