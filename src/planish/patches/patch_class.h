#pragma once

#include <compare>
#include <cstdint>

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

}  // namespace planish
