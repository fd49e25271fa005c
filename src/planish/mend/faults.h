#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec2.hpp>
#include <span>
#include <string>
#include <vector>

#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// For each vertex the one that it would be if edges had a length: the first of those that it is
/// joined with by edges of none to speak of. Boolean operations and bevels leave such edges, as
/// rounding does in files; the two ends have directions of their own all the same, and a surface
/// through both is pinched. They are edges
///   - whose ends coincide, and
///   - those that are not longer than kShortEdge of the bounding box's diagonal where all that they
///     join is kShortShare of the longest edge there, or less: small parts of a large model are
///     none.
/// Empty where there is none, and for a mesh with an index out of range or a position that is not
/// finite. Linear in time, on all threads where nothing is found.
[[nodiscard]] std::vector<std::int32_t> short_edge_targets(const PolygonMesh& mesh);

/// What six decimals leave of a model of a unit's size.
inline constexpr double kShortEdge = 2e-6;
inline constexpr double kShortShare = 1e-3;

/// Vertices at open edges that lie exactly where another one does, or as good as there, as
/// exporters write them that give each face corners of its own, with rounded numbers.
struct TornVertices {
  std::int64_t count = 0;  ///< those that --weld `reach` would take away
  std::int64_t first = -1;
  double reach = 0;  ///< of the diagonal; 0 where they lie there exactly
};

/// Of a sound mesh whose `topology` is over all its vertices; none where no two open edges lie on
/// each other.
[[nodiscard]] TornVertices torn_vertices(const PolygonMesh& mesh, const MeshTopology& topology);

/// "12 vertices at open edges lie exactly where another one does; --weld 0 makes them one", or
/// "12 vertices at open edges lie within 1e-05 of the diagonal of another one; --weld 1e-05 ...".
[[nodiscard]] std::string torn_text(const TornVertices& torn);

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

/// Where a boundary turns by more than this it has a tip or the end of a slit: no smooth curve goes
/// round it with all faces on one side.
inline constexpr double kCuspDegrees = 120;
/// And where faces reach around a boundary vertex by more than this: at the end of a slit whose
/// lips lie over each other the boundary turns by less.
inline constexpr double kCuspReachDegrees = 330;

/// Tags the boundary vertices where the boundary turns by more than kCuspDegrees, or whose faces
/// reach around them by more than kCuspReachDegrees, as corners; fair surfaces fold there else. The
/// mesh must pass check().
[[nodiscard]] PolygonMesh with_cusp_corners(const PolygonMesh& mesh);

/// Cuts indices of texture coordinates in two that belong to faces which lie either way round in
/// the texture: along the middle of charts that are mirrored in place, where the map turns back and
/// tangents jump. Once for each set of coordinates: `uvs`, as many as PolygonMesh::uvs, which get
/// the new ones' copies. Returns which index each new one copies, for the other sets.
std::vector<std::int32_t> cut_mirrored_charts(PolygonMesh& mesh, std::span<const glm::dvec2> uvs);

/// By how many corners a polygon's lie turned at most from those of the affine regular polygon that
/// the steps of Doo and Sabin make of it: the largest angle about the mean, in the coordinates in
/// which that polygon is regular, by 2 pi / n. From about 8 on the lines of a surface that come
/// from the corners and from between them cross each other (tests/pipeline/fair_fit_test.cpp).
/// 0 for affine regular polygons; half of n at most, and where that polygon is turned over or has
/// no area.
[[nodiscard]] double corner_swirl(std::span<const glm::dvec2> polygon);

/// From which corner_swirl() on faces are cut.
inline constexpr double kMostSwirl = 5;

/// Cuts a polygon without corners that turn inward by much until no part has more than kMostSwirl,
/// as far as it can be: finely drawn arcs off along their chords, and what is left in a row of
/// quads and triangles between its two sides.
/// `places`: of the corners that `part` names, counter-clockwise. `may_cut(i, j)`: whether a
/// diagonal may stay between these, asked once for each that is taken. Time of the order of n log
/// n.
[[nodiscard]] std::vector<std::vector<std::size_t>> even_parts(
    std::span<const glm::dvec2> places, std::vector<std::size_t> part,
    const std::function<bool(std::size_t, std::size_t)>& may_cut);

}  // namespace planish
