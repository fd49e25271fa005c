#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "planish/core/raw_vector.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// Which corner meets which: the connectivity of a polygon mesh, made on all threads in linear
/// time.
///
/// Corner c = first_corner(f) + i is place i of face f. Its leading edge runs from its vertex to
/// that of next(c), its trailing edge from that of prev(c) to its own. Edges are numbered in the
/// order of their first corners, and corners around a vertex come counter-clockwise: both as
/// OpenSubdiv's Far::TopologyLevel 0 of the same mesh has them.
class MeshTopology {
 public:
  /// Copies what it needs of a mesh that passes check(). Unused vertices may remain: no corner is
  /// around them. Throws Error{UnusableMesh} where faces do not meet as a manifold.
  explicit MeshTopology(const PolygonMesh& mesh);
  /// The same, or nothing where faces do not meet as a manifold. Offsets and vertices must be in
  /// range, and no face may name a vertex twice.
  [[nodiscard]] static std::optional<MeshTopology> if_manifold(const PolygonMesh& mesh);

  [[nodiscard]] std::int32_t vertex_count() const { return size_of(vertex_first_) - 1; }
  [[nodiscard]] std::int32_t edge_count() const { return size_of(edge_corner_); }
  [[nodiscard]] std::int32_t face_count() const { return size_of(face_offsets_) - 1; }
  [[nodiscard]] std::int32_t corner_count() const { return size_of(corner_vertex_); }

  /// face_count + 1: the corners of face f are [offsets[f], offsets[f+1]).
  [[nodiscard]] std::span<const std::int32_t> face_offsets() const { return face_offsets_; }
  [[nodiscard]] std::int32_t first_corner(std::int32_t face) const { return face_offsets_[face]; }
  [[nodiscard]] std::int32_t face_size(std::int32_t face) const {
    return face_offsets_[face + 1] - face_offsets_[face];
  }
  /// The vertices of a face.
  [[nodiscard]] std::span<const std::int32_t> face(std::int32_t index) const {
    return std::span(corner_vertex_).subspan(face_offsets_[index], face_size(index));
  }
  /// The leading edges of a face's corners.
  [[nodiscard]] std::span<const std::int32_t> face_edges(std::int32_t index) const {
    return std::span(corner_edge_).subspan(face_offsets_[index], face_size(index));
  }

  // By corner.
  [[nodiscard]] std::span<const std::int32_t> corner_faces() const { return corner_face_; }
  [[nodiscard]] std::int32_t vertex_of(std::int32_t corner) const { return corner_vertex_[corner]; }
  [[nodiscard]] std::int32_t face_of(std::int32_t corner) const { return corner_face_[corner]; }
  [[nodiscard]] std::int32_t edge_of(std::int32_t corner) const { return corner_edge_[corner]; }
  /// The corner whose leading edge is the same edge the other way round; -1 at a boundary.
  [[nodiscard]] std::int32_t twin(std::int32_t corner) const { return twin_[corner]; }
  /// The corner's place in its face.
  [[nodiscard]] std::int32_t place_of(std::int32_t corner) const {
    return corner - face_offsets_[corner_face_[corner]];
  }
  [[nodiscard]] std::int32_t next(std::int32_t corner) const {
    const std::int32_t face = corner_face_[corner];
    return corner + 1 == face_offsets_[face + 1] ? face_offsets_[face] : corner + 1;
  }
  [[nodiscard]] std::int32_t prev(std::int32_t corner) const {
    const std::int32_t face = corner_face_[corner];
    return (corner == face_offsets_[face] ? face_offsets_[face + 1] : corner) - 1;
  }
  /// The corner at the same vertex across the trailing edge; -1 at a boundary.
  [[nodiscard]] std::int32_t ccw(std::int32_t corner) const { return twin_[prev(corner)]; }
  /// The corner at the same vertex across the leading edge; -1 at a boundary.
  [[nodiscard]] std::int32_t cw(std::int32_t corner) const {
    const std::int32_t other = twin_[corner];
    return other < 0 ? -1 : next(other);
  }

  // By edge.
  /// The smaller one of the corners whose leading edge it is.
  [[nodiscard]] std::int32_t corner_of(std::int32_t edge) const { return edge_corner_[edge]; }
  [[nodiscard]] bool is_boundary_edge(std::int32_t edge) const {
    return twin_[edge_corner_[edge]] < 0;
  }
  /// Its ends, in the direction of its corner.
  [[nodiscard]] std::pair<std::int32_t, std::int32_t> edge_vertices(std::int32_t edge) const {
    const std::int32_t corner = edge_corner_[edge];
    return {corner_vertex_[corner], corner_vertex_[next(corner)]};
  }
  /// The edge between two vertices in any order, -1 if there is none; takes time in proportion to
  /// the lower of their valences.
  [[nodiscard]] std::int32_t find_edge(std::int32_t v0, std::int32_t v1) const;

  // By vertex.
  /// vertex_count + 1: vertex v has corners_at(v).size() = offsets[v+1] - offsets[v] corners.
  [[nodiscard]] std::span<const std::int32_t> corner_offsets() const { return vertex_first_; }
  /// The corners at a vertex, counter-clockwise: at a boundary from the one whose leading edge is
  /// the boundary, elsewhere from the smallest. ccw() goes from each to the one behind it.
  [[nodiscard]] std::span<const std::int32_t> corners_at(std::int32_t vertex) const {
    return std::span(vertex_corners_)
        .subspan(vertex_first_[vertex], vertex_first_[vertex + 1] - vertex_first_[vertex]);
  }
  [[nodiscard]] bool is_boundary_vertex(std::int32_t vertex) const {
    return vertex_first_[vertex] < vertex_first_[vertex + 1] &&
           twin_[vertex_corners_[vertex_first_[vertex]]] < 0;
  }
  /// Edges at a vertex: its corners, and one more at a boundary.
  [[nodiscard]] std::int32_t valence(std::int32_t vertex) const {
    return vertex_first_[vertex + 1] - vertex_first_[vertex] + (is_boundary_vertex(vertex) ? 1 : 0);
  }

 private:
  MeshTopology() = default;
  static std::int32_t size_of(const RawVector<std::int32_t>& values) {
    return static_cast<std::int32_t>(values.size());
  }
  void take_faces(const PolygonMesh& mesh);
  void gather_corners();
  [[nodiscard]] bool join_corners();
  void number_edges();

  RawVector<std::int32_t> face_offsets_, corner_vertex_, corner_face_, twin_, corner_edge_;
  RawVector<std::int32_t> edge_corner_, vertex_first_, vertex_corners_;
};

/// What fit(), evaluate() and reports want to know of a mesh's faces, found once for all of them:
/// that the mesh passes check(), and how its corners meet. Holds as long as faces, tags and the
/// number of vertices stay; positions may change.
struct PreparedMesh {
  RawVector<std::int32_t> vertices;              ///< those that faces name, ascending
  std::shared_ptr<const MeshTopology> topology;  ///< over these vertices, numbered anew
  std::int32_t given_vertex_count = 0;           ///< with unused ones

  [[nodiscard]] bool uses_all() const {
    return static_cast<std::int32_t>(vertices.size()) == given_vertex_count;
  }
};

/// Null where the mesh has a problem that check() reports.
[[nodiscard]] std::shared_ptr<const PreparedMesh> prepare_if_sound(const PolygonMesh& mesh);

/// Throws as require_usable().
[[nodiscard]] std::shared_ptr<const PreparedMesh> prepare_mesh(const PolygonMesh& mesh,
                                                               std::string_view name);

/// Of a mesh whose faces name all vertices and have been found sound; `topology` is its.
[[nodiscard]] std::shared_ptr<const PreparedMesh> prepared_whole(
    const PolygonMesh& mesh, std::shared_ptr<const MeshTopology> topology);

/// A mesh without the vertices that no face names: the given mesh itself where there are none, else
/// a copy.
struct UsedPart {
  std::shared_ptr<const PreparedMesh> prepared;
  std::unique_ptr<const PolygonMesh> copy;
  const PolygonMesh& mesh;
  std::span<const std::int32_t> vertices;  ///< the original index of each vertex, ascending
};

/// `mesh` is the one that was prepared, but for positions, and must outlive the result. Corner tags
/// of unused vertices are dropped.
[[nodiscard]] UsedPart used_part(const PolygonMesh& mesh,
                                 std::shared_ptr<const PreparedMesh> prepared);
UsedPart used_part(PolygonMesh&& mesh, std::shared_ptr<const PreparedMesh> prepared) = delete;

/// A place on the surface of a mesh's face, as OpenSubdiv's Bfr::Parameterization has it. On a face
/// of four, (u, v) in [0, 1]^2 with corner i at (0, 0), (1, 0), (1, 1), (0, 1). On others (u, v)
/// lies in one of m tiles of half a unit, one a corner, at (i % d, i / d): its origin is at the
/// corner, u runs along the face's edge to the next one, and (1/2, 1/2) is the face's centre; d = 2
/// up to four faces, 3 up to nine, then 1 + floor(sqrt(m - 1)).
struct SurfaceParameter {
  std::int32_t face = 0;
  double u = 0, v = 0;
};

/// The same seen from the corner that it belongs to: u runs from the corner's vertex to the
/// midpoint of its leading edge, v to that of its trailing edge, both from 0 to 1; (1, 1) is the
/// face's centre.
struct CornerParameter {
  std::int32_t corner = 0;
  double u = 0, v = 0;
  /// How derivatives by (u, v) become those by a SurfaceParameter's, see PatchPoint::turned() with
  /// factor 2.
  int turn_c = 1, turn_s = 0;
};

/// Throws Error{InvalidArgument} for a face that is none, and for places further than 1e-9 outside
/// it; nearer ones are taken to the border.
[[nodiscard]] CornerParameter corner_parameter(const MeshTopology& topology,
                                               const SurfaceParameter& at);

/// The inverse. (u, v) must be in [0, 1]^2.
[[nodiscard]] SurfaceParameter surface_parameter(const MeshTopology& topology, std::int32_t corner,
                                                 double u, double v);

}  // namespace planish
