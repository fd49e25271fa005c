#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "planish/brep/spline_surface.h"

namespace planish {

/// What the control points beside the limit point are moved by, seen from an extraordinary point:
/// of the border along x, c_10, of that along y, c_01, and c_11 inside. Those of borders are the
/// same for both sides.
struct CapMove {
  glm::dvec3 along_x{}, along_y{}, inside{};
};

/// Basis functions on knots 0 (degree + 1 times), 1, 2, in squares of 2^-depth: that of the limit
/// point, not 0 in [0, 1), and that of c_10 along x, not 0 in (0, 2).
class CapBasis {
 public:
  explicit CapBasis(std::size_t degree) : degree_(degree), last_(degree == 2 ? 0.5 : 0.25) {}

  [[nodiscard]] double limit(double t) const { return t < 1 ? power(1 - t, degree_) : 0; }
  [[nodiscard]] double beside(double t) const {
    if (t >= 1) return t < 2 ? last_ * power(2 - t, degree_) : 0;
    return degree_ == 2 ? 2 * t - 1.5 * t * t : 3 * t - 4.5 * t * t + 1.75 * t * t * t;
  }
  /// The derivative of beside(), by the degree.
  [[nodiscard]] double beside_slope(double t) const {
    if (t >= 1) return t < 2 ? -last_ * power(2 - t, degree_ - 1) : 0;
    return degree_ == 2 ? 1 - 1.5 * t : 1 - 3 * t + 1.75 * t * t;
  }
  /// What a place moves by, x and y in squares of 2^-depth from the point.
  [[nodiscard]] glm::dvec3 moved_by(const CapMove& move, double x, double y) const {
    const double x1 = beside(x), y1 = beside(y);
    return x1 * limit(y) * move.along_x + limit(x) * y1 * move.along_y + x1 * y1 * move.inside;
  }
  /// Moves the polynomial on [x, x + size] x [y, y + size], which has no square's border inside.
  void add_move(const CapMove& move, double x, double y, double size, PointNet& net) const;

 private:
  static double power(double base, std::size_t exponent) {
    return exponent == 3 ? base * base * base : exponent == 2 ? base * base : base;
  }
  // Of the polynomials of the square that holds t.
  [[nodiscard]] double limit_blossom(double t, const BlossomArguments& arguments) const;
  [[nodiscard]] double beside_blossom(double t, const BlossomArguments& arguments) const;

  std::size_t degree_;
  double last_;  ///< of beside() at 1
};

/// A corner's patch as polynomials that cover it. Where it has a point in no polynomial, at its
/// vertex V or its face's centre F, the square of 2^-depth there has the one polynomial of the
/// surface's degree that joins its neighbours as smoothly as these one another, passes through the
/// limit point, and whose borders depend on nothing but the surface on them.
class CornerPieces {
 public:
  /// Depths at V and F are at least 1; the patch has been moved to its corner.
  CornerPieces(SplinePatch& patch, std::size_t degree, const std::array<int, 2>& depths);

  /// Moves the points beside the limit point at V, or that at F, whose depth it was made with.
  void move(const CapMove& move, bool is_face, int depth);

  [[nodiscard]] const SquarePiece& at(double u, double v) const;

 private:
  void add_cap(const SplinePatch::End& end, int depth);

  std::size_t degree_;
  std::vector<SquarePiece> pieces_;
};

}  // namespace planish
