#pragma once

#include <cstdint>
#include <optional>
#include <span>
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

}  // namespace planish
