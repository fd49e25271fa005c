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
struct PatchClass {
  PatchKind kind = PatchKind::Smooth;
  std::int32_t ring_size = 0;  ///< k
  std::int32_t place = 0;      ///< of the own face in its sector; 0 where Smooth or Cone
  std::int32_t face_size = 0;  ///< m

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
    return !has_sharp_edges() ? 0 : kind == PatchKind::Dart ? 1 : 2;
  }
  [[nodiscard]] bool has_vertex() const {
    return kind != PatchKind::Smooth && kind != PatchKind::Dart && kind != PatchKind::Crease;
  }

  // Columns.
  [[nodiscard]] std::int32_t face_column(std::int32_t i) const {
    return i == place ? 0 : i < place ? i + 1 : i;
  }
  [[nodiscard]] std::int32_t curve_column(std::int32_t i) const {
    return kind == PatchKind::Dart ? ring_size : ring_size + i;
  }
  [[nodiscard]] std::int32_t vertex_column() const { return ring_size + curve_count(); }
  /// Of the i-th further point of the face, from 1 on.
  [[nodiscard]] std::int32_t ring_column(std::int32_t i) const {
    return ring_size + curve_count() + (has_vertex() ? 1 : 0) + i - 1;
  }
  [[nodiscard]] std::int32_t leading_column() const { return ring_column(face_size); }
  [[nodiscard]] std::int32_t trailing_column() const { return ring_column(face_size) + 1; }
  /// K.
  [[nodiscard]] std::int32_t column_count() const {
    return is_limit_only() ? ring_column(1) : ring_column(face_size) + 2;
  }
};

}  // namespace planish
