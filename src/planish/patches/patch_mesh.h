#pragma once

#include <compare>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/doosabin/subdivision.h"
#include "planish/mesh/mesh_topology.h"

namespace planish {

/// What a corner patch has at its vertex V.
enum class PatchKind : std::uint8_t {
  Smooth,  ///< a ring of faces; or a dart, away from its sharp edge
  Cone,    ///< a tagged vertex without sharp edges
  Dart,    ///< beside the one sharp edge of a vertex
  Crease,  ///< a sector of faces between two sharp edges, or at a boundary
  Convex,  ///< the same at a corner, by the sector's opening
  HalfPlane,
  Reflex,
};

/// A corner patch is the surface over the quad V, E1, F, E2 of Q_1: V the corner's vertex, E1 and
/// E2 the midpoints of its leading and trailing edge, F the centre of its face. u runs from V to
/// E1, v from V to E2. All patches of a class are the same linear map of their control points,
/// which are its columns, in this order:
///   - the corner's own point;
///   - the others of the k faces around V counter-clockwise: from the own one on where V is Smooth
///     or Cone, else all of the sector (Dart: from the sharp edge on) but the own one;
///   - curve points at V of the edges before and after the sector (Dart: the one that there is);
///   - V itself (Cone, Convex, HalfPlane, Reflex);
///   - the others of the face's m points counter-clockwise;
///   - for the leading edge, then the trailing: the point across its far half, or where it is sharp
///     the far half's curve point.
/// Without a face (m = 0) it is a limit point alone: of V, of an edge's midpoint, of a face's
/// centre.
/// Of a ring or sector by its sums (RingSums) there are six columns instead: the own point, the
/// next and the previous one, mean, cosine and sine sum, and of curve points only that of a sharp
/// edge of the own face; a face by its sums has the next and the previous point and the three sums.
struct PatchClass {
  PatchKind kind = PatchKind::Smooth;
  std::int32_t ring_size = 0;  ///< k
  /// Of the own face in its sector; 0 where Smooth or Cone. By sums: 0, k - 1, or 1 for all
  /// between.
  std::int32_t place = 0;
  std::int32_t face_size = 0;  ///< m
  bool has_ring_sums = false, has_face_sums = false;

  friend auto operator<=>(const PatchClass&, const PatchClass&) = default;

  [[nodiscard]] bool is_limit_only() const { return face_size == 0; }
  [[nodiscard]] bool has_sharp_edges() const {
    return kind != PatchKind::Smooth && kind != PatchKind::Cone;
  }
  [[nodiscard]] bool is_leading_sharp() const { return has_sharp_edges() && place == 0; }
  [[nodiscard]] bool is_trailing_sharp() const {
    return has_sharp_edges() && place == ring_size - 1;
  }
  [[nodiscard]] std::int32_t curve_count() const {
    if (!has_sharp_edges()) return 0;
    if (has_ring_sums) return is_leading_sharp() || is_trailing_sharp() ? 1 : 0;
    return kind == PatchKind::Dart ? 1 : 2;
  }
  [[nodiscard]] bool has_vertex() const {
    return kind != PatchKind::Smooth && kind != PatchKind::Dart && kind != PatchKind::Crease;
  }

  // Columns.
  [[nodiscard]] std::int32_t face_column(std::int32_t i) const {
    return i == place ? 0 : i < place ? i + 1 : i;
  }
  /// Of the face `offset` (-1, 0 or 1) places behind the own one.
  [[nodiscard]] std::int32_t face_column_beside(std::int32_t offset) const {
    if (!has_ring_sums) return face_column((place + offset + ring_size) % ring_size);
    return offset == 0 ? 0 : offset == 1 ? 1 : 2;
  }
  [[nodiscard]] std::int32_t curve_column(std::int32_t i) const {
    return ring_column_count() + (curve_count() == 1 ? 0 : i);
  }
  [[nodiscard]] std::int32_t vertex_column() const { return ring_column_count() + curve_count(); }
  /// Of the i-th further point of the face, from 1 on; by sums only the first and the last.
  [[nodiscard]] std::int32_t ring_column(std::int32_t i) const {
    return first_face_column() + (!has_face_sums ? i - 1 : i == 1 ? 0 : 1);
  }
  /// Of mean, cosine and sine sum, around V and of the face.
  [[nodiscard]] std::int32_t ring_sums_column() const { return 3; }
  [[nodiscard]] std::int32_t face_sums_column() const { return first_face_column() + 2; }
  [[nodiscard]] std::int32_t leading_column() const {
    return first_face_column() + (has_face_sums ? 5 : face_size - 1);
  }
  [[nodiscard]] std::int32_t trailing_column() const { return leading_column() + 1; }
  /// K.
  [[nodiscard]] std::int32_t column_count() const {
    return is_limit_only() ? first_face_column() : trailing_column() + 1;
  }

 private:
  [[nodiscard]] std::int32_t ring_column_count() const { return has_ring_sums ? 6 : ring_size; }
  [[nodiscard]] std::int32_t first_face_column() const {
    return ring_column_count() + curve_count() + (has_vertex() ? 1 : 0);
  }
};

/// How patches take rings, sectors and faces from kSummedRing on: by each of their points, or by
/// sums, which Doo and Sabin's weights allow.
enum class RingColumns { Points, Sums };

/// Faces around a vertex, and corners of a face, that are taken by points: time and memory are
/// their square. A second and some 1.5 GB for one such vertex amid a boundary.
inline constexpr std::int32_t kLargestByPoints = 1024;

/// How they are taken with these weights. Throws Error{UnusableMesh} for the first vertex or face
/// with more than kLargestByPoints where that is by points. `vertices`: their numbers in messages;
/// none: the topology's.
[[nodiscard]] RingColumns ring_columns(const MeshTopology& topology, Weights weights,
                                       std::span<const std::int32_t> vertices = {});

/// A large ring or sector of faces around a vertex, or of corners around a face. All that its rule
/// needs of it are a mean M and two vectors U, W that turn with the place i, at angle a_i:
///
///   X'_i = X_i / 4 + 3/4 M + (cos a_i U + sin a_i W) / 4
///
/// Around a vertex or face M, U and W are the mean and the first Fourier pair of its points. In a
/// sector that the curve through its vertex bounds M is the vertex, U the curve's direction, W the
/// points' way from it. At corner vertices, whose points shrink to V, it is V / 2 + M / 4 instead
/// of 3/4 M, and in convex and reflex sectors M is V. See subdivision.cpp, whose rules these are.
struct LargeRing {
  PatchKind kind = PatchKind::Smooth;  ///< Dart: of the whole ring
  std::int32_t start = 0;              ///< the corner at place 0; they follow counter-clockwise
  std::int32_t size = 0;
  /// The place in the state of M, M + cos a_i U + sin a_i W and M + cos a_i W - sin a_i U of
  /// corner 0, behind which are those of the others.
  std::int32_t first_sum = 0;

  [[nodiscard]] bool is_sector() const {
    return kind != PatchKind::Smooth && kind != PatchKind::Cone && kind != PatchKind::Dart;
  }
  [[nodiscard]] std::int32_t sum_count() const { return 3 * size; }
};

/// a_0, and what lies between two places.
struct RingAngles {
  double first, step;
};
[[nodiscard]] RingAngles ring_angles(PatchKind kind, std::int32_t size);

/// Weights of a ring's points in M, U and W: one row a point, which are its faces' points, of a
/// sector also its two curve points and, at a corner vertex, the vertex itself. Columns sum to 1, 0
/// and 0.
[[nodiscard]] std::vector<glm::dvec3> ring_weights(const LargeRing& ring);

/// Writes the ring's sums, of its points in that order.
void write_ring_sums(const LargeRing& ring, std::span<const glm::dvec3> points, glm::dvec3* sums);

/// The weights of a ring's points in one of its sums, by its place behind `first_sum`.
[[nodiscard]] std::vector<double> sum_weights(const LargeRing& ring, std::int32_t sum);

/// Control points of a patch: its class and where they are gathered from.
struct PatchPlace {
  enum class Around { Vertex, Edge, Face };

  PatchClass patch;
  /// Whose points come first.
  Around around;
  /// A corner patch's corner; of a limit point the corner of the own face.
  std::int32_t corner;
  /// Where V's sector begins, if it has one.
  std::int32_t sector_start;
};

/// The corner patches of a mesh: their classes, and their points in the state of level 1 (see
/// Subdivision), behind which stand the sums of large rings. Topology and features must outlive it.
class PatchMesh {
 public:
  PatchMesh(const MeshTopology& topology, const SharpFeatures& features,
            RingColumns columns = RingColumns::Points);

  [[nodiscard]] const MeshTopology& topology() const { return topology_; }
  [[nodiscard]] const SharpFeatures& features() const { return features_; }
  [[nodiscard]] std::int32_t first_sharp() const { return topology_.corner_count(); }
  [[nodiscard]] std::int32_t first_corner_vertex() const {
    return first_sharp() + 2 * features_.sharp_edge_count;
  }
  [[nodiscard]] std::int32_t state_size() const {
    return first_corner_vertex() + features_.corner_count;
  }
  /// The state's and the sums'.
  [[nodiscard]] std::int32_t point_count() const { return state_size() + sum_count_; }
  [[nodiscard]] bool has_sums() const { return sum_count_ > 0; }
  /// The points that are gathered from: a state of level 1 and its sums.
  [[nodiscard]] RawVector<glm::dvec3> with_sums(std::span<const glm::dvec3> state) const;
  /// Sets the sums of points (point_count()) whose state is there.
  void update_sums(std::span<glm::dvec3> points) const;
  /// The same of the rings around some corners' vertices and of their faces.
  void update_sums_at(std::span<const std::int32_t> corners, std::span<glm::dvec3> points) const;
  [[nodiscard]] std::span<const LargeRing> large_rings() const { return rings_; }
  /// A large ring's points in the order of ring_weights().
  void ring_points(const LargeRing& ring, std::vector<std::int32_t>& points) const;
  /// The ring that a sum is of.
  [[nodiscard]] const LargeRing& ring_of_sum(std::int32_t point) const;
  /// Whether one of large_rings() is of a face's corners, not around a vertex.
  [[nodiscard]] bool is_face_ring(const LargeRing& ring) const {
    return &ring >= rings_.data() + vertex_ring_count_;
  }

  [[nodiscard]] bool is_sharp_edge(std::int32_t edge) const {
    return !features_.sharp_of_edge.empty() && features_.sharp_of_edge[edge] >= 0;
  }
  /// Of a corner's leading edge.
  [[nodiscard]] bool is_sharp(std::int32_t corner) const {
    return !features_.sharp_of_edge.empty() && is_sharp_edge(topology_.edge_of(corner));
  }
  /// The first corner of the sector that a corner of a crease or corner vertex lies in: that with a
  /// sharp leading edge. A tagged vertex without sharp edges has no sectors: -1.
  [[nodiscard]] std::int32_t sector_start(std::int32_t corner) const;
  /// The first corners of a vertex's sectors in their order; the first corner at the vertex where
  /// there are none.
  void sector_starts(std::int32_t vertex, std::vector<std::int32_t>& starts) const;

  /// The one of them in whose sector a corner lies.
  [[nodiscard]] std::int32_t sector_corner(std::int32_t corner) const;

  [[nodiscard]] PatchPlace corner_patch(std::int32_t corner) const;
  /// The limit point of a vertex in the sector that begins with `start`, see sector_starts().
  [[nodiscard]] PatchPlace vertex_point(std::int32_t start) const;
  /// The limit point of an edge's midpoint, seen from the corner's face whose leading edge it is.
  [[nodiscard]] PatchPlace edge_point(std::int32_t corner) const;
  [[nodiscard]] PatchPlace face_point(std::int32_t face) const;

  /// Indices of the points of a place in the order of its class's columns, `stride` apart.
  void gather(const PatchPlace& place, std::int32_t* indices, std::ptrdiff_t stride) const;

 private:
  // Of a corner's vertex, sector or face where that is large, with the corner's place there.
  struct PlaceInRing {
    const LargeRing* ring = nullptr;
    std::int32_t place = 0;
    [[nodiscard]] std::int32_t first_sum() const { return ring->first_sum + 3 * place; }
  };
  [[nodiscard]] PlaceInRing ring_around_vertex(std::int32_t corner) const {
    if (ring_of_corner_.empty() || ring_of_corner_[corner] < 0) return {};
    return {&rings_[ring_of_corner_[corner]], place_of_corner_[corner]};
  }
  [[nodiscard]] PlaceInRing ring_of_face(std::int32_t corner) const;
  void update_ring(const LargeRing& ring, std::span<glm::dvec3> points) const;
  void find_large_rings();
  void add_ring(PatchKind kind, std::int32_t start, std::int32_t size, bool is_face);
  [[nodiscard]] static PatchClass by_sums(const PlaceInRing& at);
  [[nodiscard]] PatchPlace around_vertex(std::int32_t corner) const;
  [[nodiscard]] PatchKind sector_kind(std::int32_t start) const;
  [[nodiscard]] std::int32_t sector_size(std::int32_t start) const;
  // The curve point of a corner's sharp leading edge at the corner's end of it, and at the other.
  [[nodiscard]] std::int32_t curve_at_tail(std::int32_t corner) const;
  [[nodiscard]] std::int32_t curve_at_head(std::int32_t corner) const;

  const MeshTopology& topology_;
  const SharpFeatures& features_;
  // Around vertices, then of faces, each in the order of their sums.
  std::vector<LargeRing> rings_;
  std::size_t vertex_ring_count_ = 0;
  std::int32_t sum_count_ = 0;
  std::vector<std::int32_t> ring_of_corner_, place_of_corner_;  // around vertices; or empty
};

}  // namespace planish
