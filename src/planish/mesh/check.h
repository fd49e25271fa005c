#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish {

enum class MeshProblemKind {
  NoFaces,
  NonFinitePosition,         ///< element: vertex that is not finite or beyond kMaxCoordinate
  IndexOutOfRange,           ///< element: face whose corners or vertices do not exist
  WrongAttributeCount,       ///< colours, texture corners or groups: neither none nor one for each
  UnknownTextureCoordinate,  ///< element: corner whose texture coordinate does not exist
  UnknownGroup,              ///< element: face whose group does not exist
  FaceTooSmall,              ///< element: face with fewer than 3 corners
  RepeatedCorner,            ///< element: face that names a vertex twice
  DuplicateFace,             ///< element: the later face of two with the same vertices
  InconsistentWinding,       ///< element: face that runs along an edge in its neighbour's direction
  NonManifoldEdge,           ///< element: the last face at an edge with three or more faces
  NonManifoldVertex,         ///< element: vertex with more than one fan of faces
  UnknownCreaseEdge,         ///< element: index of a crease that is no edge, or of sharpness NaN
  UnknownCornerVertex,  ///< element: index of a corner that is no used vertex, or of sharpness NaN
  UnknownHole,          ///< element: index of a hole that is no face
  ValenceTooHigh,       ///< element: vertex or face above OpenSubdiv's limit of 65535
  TooLarge,             ///< what 32 bits cannot number; element: the largest face, or -1
  NoExtent,             ///< all vertices that faces name coincide
};

/// Largest magnitude of a coordinate: a product of two must stay finite.
inline constexpr double kMaxCoordinate = 1e150;
/// OpenSubdiv's limit on the corners of a face and on the faces and edges at a vertex.
inline constexpr std::int32_t kMaxValence = 65535;

/// What is said of NoFaces.
inline constexpr const char* kNoFacesMessage =
    "the mesh has no faces; give it some, or save its vertices as points (.xyz, .ply)";

/// Stable name, e.g. "non-manifold-edge"; used in reports.
[[nodiscard]] std::string_view name_of(MeshProblemKind kind);

struct MeshProblem {
  MeshProblemKind kind;
  std::int64_t element;  ///< 0-based index, see MeshProblemKind; -1 for none
  std::string message;   ///< "face 12 names vertex 4031 of 4030", 0-based indices
};

/// Every reason why no surface can be made of the mesh, in the order of the kinds above, then of
/// the elements. Edges and fans are those of the faces without a problem of their own. Empty: the
/// mesh can be refined. Unused vertices are no problem. Never throws but
/// for std::bad_alloc; arrays may hold anything and have any size.
[[nodiscard]] std::vector<MeshProblem> check(const PolygonMesh& mesh);

/// Throws Error{UnusableMesh} naming `name`, the first ten problems and, where repair() mends all
/// of them, that; nothing when there is none.
void require_usable(const PolygonMesh& mesh, std::string_view name);

}  // namespace planish
