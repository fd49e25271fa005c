#pragma once

#include <array>
#include <glm/vec3.hpp>
#include <vector>

#include "planish/limit/bezier_net.h"
#include "planish/limit/limit_surface.h"
#include "planish/limit/patch_box.h"
#include "planish/limit/patch_frame.h"

namespace planish {

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

/// What a halving of a quarter that is no polynomial leaves: three polynomials, and the rest around
/// its vertex V.
struct PatchRing {
  std::array<PatchPiece, 3> pieces;
  std::array<PatchBox, 3> boxes;
  PatchBox rest;
};

/// The polynomials that a corner's patch consists of, by halves, ready to be asked often. Keeps its
/// room from corner to corner.
class PatchPieces {
 public:
  PatchPieces(const LimitSurface& surface, const PatchReaches& reaches)
      : corner_(surface), reaches_(reaches) {}

  void move_to(std::int32_t corner);
  [[nodiscard]] glm::dvec3 own() const { return corner_.own(); }
  /// Around quarter 0 to 3, relative to the corner's own point.
  [[nodiscard]] const PatchBox& box(std::size_t quarter) const { return boxes_[quarter]; }
  /// Of a quarter; null where it is no polynomial.
  [[nodiscard]] const PatchPiece* piece(std::size_t quarter) const {
    return has_piece_[quarter] ? &pieces_[quarter] : nullptr;
  }
  /// The limit point at V of a quarter that is no polynomial, and where it lies.
  [[nodiscard]] const glm::dvec3& vertex(std::size_t quarter) const {
    return inside_[quarter].vertex;
  }
  [[nodiscard]] static PatchFrame vertex_frame(std::size_t quarter) {
    return PatchFrame().quarter(static_cast<int>(quarter));
  }
  /// Of such a quarter, outwards in: by halving 0, 1, ...; null after the last. Made when asked
  /// for.
  [[nodiscard]] const PatchRing* ring(std::size_t quarter, std::size_t halving);

 private:
  // A quarter that is no polynomial, as far as it was asked for.
  struct Inside {
    glm::dvec3 vertex{0.0};
    std::vector<PatchRing> rings;
    // What the rings leave.
    const PatchForm* form = nullptr;
    PatchFrame frame;
    std::vector<glm::dvec3> points;
  };
  void enter(std::size_t quarter, const PatchForm& form);

  LimitSurface::Corner corner_;
  const PatchReaches& reaches_;
  std::int32_t at_ = -1;  // the corner that pieces and boxes are of
  std::array<PatchPiece, 4> pieces_{};
  std::array<bool, 4> has_piece_{};
  std::array<PatchBox, 4> boxes_{};
  std::array<Inside, 4> inside_;
  std::vector<glm::dvec3> points_;
};

}  // namespace planish
