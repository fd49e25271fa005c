#pragma once

#include <array>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <utility>
#include <vector>

#include "planish/limit/cell_bound.h"
#include "planish/limit/limit_surface.h"
#include "planish/limit/patch_box.h"

namespace planish {

/// Where a square that quarters within quarters lead to lies in its patch: its own (u, v) are
/// turned by quarter turns, shrunk and moved.
struct PatchFrame {
  double u = 0, v = 0, size = 1;
  int c = 1, s = 0;

  /// Quarter 0 to 3 of the square, as PatchForm has them.
  [[nodiscard]] PatchFrame quarter(int index) const;
  [[nodiscard]] glm::dvec2 at(double own_u, double own_v) const {
    return {u + size * (c * own_u - s * own_v), v + size * (s * own_u + c * own_v)};
  }
};

/// A polynomial that a patch or a part of it is, its points relative to the corner's own.
struct PatchPiece {
  BezierNet net{};
  PatchFrame frame;

  /// By the piece's own (u, v) in [0, 1]^2.
  [[nodiscard]] PatchPoint at(double own_u, double own_v) const;
  /// No point of it is nearer to `point`, by a plane across the way to its middle; 0 where that
  /// tells nothing.
  [[nodiscard]] double least_distance(const glm::dvec3& point) const;
  [[nodiscard]] PatchBox box() const;
  /// A quarter, not turned.
  [[nodiscard]] PatchPiece half(bool upper_u, bool upper_v) const;
};

/// The polynomials that a corner's patch consists of, by halves, ready to be asked often. Keeps its
/// room from corner to corner.
class PatchPieces {
 public:
  PatchPieces(const LimitSurface& surface, const PatchReaches& reaches)
      : corner_(surface), reaches_(reaches) {}

  void move_to(std::int32_t corner);
  [[nodiscard]] LimitSurface::Corner& corner() { return corner_; }
  /// Around quarter 0 to 3, relative to the corner's own point.
  [[nodiscard]] const PatchBox& box(std::size_t quarter) const { return boxes_[quarter]; }
  /// Of a quarter; null where it is no polynomial.
  [[nodiscard]] const PatchPiece* piece(std::size_t quarter) const {
    return has_piece_[quarter] ? &pieces_[quarter] : nullptr;
  }

  /// The inside of a quarter that is no polynomial, from its vertex V outwards by ever further
  /// halvings: calls take(point, frame) with V itself, then for each halving take(piece) for the
  /// three polynomials that it leaves, and goes on while is_near(box) of what is left around V.
  template <class TakePoint, class TakePiece, class IsNear>
  void visit(std::size_t quarter, const TakePoint& take_point, const TakePiece& take_piece,
             const IsNear& is_near);

 private:
  [[nodiscard]] PatchBox box_around(const PatchForm& form,
                                    std::span<const glm::dvec3> points) const;

  LimitSurface::Corner corner_;
  const PatchReaches& reaches_;
  std::int32_t at_ = -1;  // the corner that pieces and boxes are of
  std::array<PatchPiece, 4> pieces_{};
  std::array<bool, 4> has_piece_{};
  std::array<PatchBox, 4> boxes_{};
  std::vector<glm::dvec3> points_, next_;
};

template <class TakePoint, class TakePiece, class IsNear>
void PatchPieces::visit(std::size_t quarter, const TakePoint& take_point,
                        const TakePiece& take_piece, const IsNear& is_near) {
  const PatchForm* form = corner_.form().quarters[quarter];
  PatchFrame frame = PatchFrame().quarter(static_cast<int>(quarter));
  quarter_points(corner_.form(), static_cast<int>(quarter), corner_.points(), points_);
  glm::dvec3 vertex(0.0);
  for (std::size_t k = 0; k < points_.size(); ++k) vertex += form->corner[k] * points_[k];
  take_point(vertex, frame);
  PatchPiece piece;
  for (int depth = 0; depth < form->halvings; ++depth) {
    for (int q = 1; q < 4; ++q) {
      quarter_points(*form, q, points_, next_);
      bezier_points(*form->quarters[q], next_, piece.net);
      piece.frame = frame.quarter(q);
      take_piece(piece);
    }
    quarter_points(*form, 0, points_, next_);
    std::swap(points_, next_);
    form = form->quarters[0];
    frame = frame.quarter(0);
    if (!is_near(box_around(*form, points_))) return;
  }
}

}  // namespace planish
