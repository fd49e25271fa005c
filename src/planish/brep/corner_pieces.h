#pragma once

#include <cstdint>
#include <vector>

#include "planish/limit/bezier_net.h"
#include "planish/limit/limit_surface.h"

namespace planish {

/// Two arguments of a polynomial of degree 2's blossom.
struct BlossomPair {
  double first = 0, second = 0;
};

/// A polynomial over a square of a corner's (u, v), in unit coordinates.
struct SquarePiece {
  double u = 0, v = 0, size = 1;
  BezierNet net{};

  [[nodiscard]] bool holds(double at_u, double at_v) const {
    return at_u >= u && at_u <= u + size && at_v >= v && at_v <= v + size;
  }
  [[nodiscard]] glm::dvec3 blossom(BlossomPair along_u, BlossomPair along_v) const;
};

/// What the control points beside the limit point are moved by, seen from an extraordinary point:
/// of the border along x, c_10, of that along y, c_01, and c_11 inside. Those of borders are the
/// same for both sides.
struct CapMove {
  glm::dvec3 along_x{}, along_y{}, inside{};
};

/// The basis function of c_10 along x, in squares of 2^-depth: not 0 in (0, 2).
[[nodiscard]] double move_basis(double x);
/// What a place moves by, x and y in squares of 2^-depth from the point.
[[nodiscard]] glm::dvec3 moved_by(const CapMove& move, double x, double y);
/// Moves the polynomial on [x, x + size] x [y, y + size], which has no square's border inside.
void add_move(const CapMove& move, double x, double y, double size, BezierNet& net);

/// A corner's patch as polynomials that cover it. Where it has a point in no polynomial, at its
/// vertex V or its face's centre F, the square of 2^-depth there has the one biquadratic polynomial
/// that joins its neighbours with C1, passes through the limit point, and whose borders depend on
/// nothing but the surface on them.
class CornerPieces {
 public:
  /// Depths are at least 1; the corner has been moved to.
  CornerPieces(LimitSurface::Corner& corner, int depth_at_vertex, int depth_at_face);

  /// Moves the points beside the limit point at V, or that at F, whose depth it was made with.
  void move(const CapMove& move, bool is_face, int depth);

  [[nodiscard]] const SquarePiece& at(double u, double v) const;

 private:
  // The quarter 0 or 2, which is no polynomial.
  void add_end(const PatchForm& end, std::vector<glm::dvec3> points, int quarter, int depth);

  glm::dvec3 own_;
  std::vector<SquarePiece> pieces_;
};

}  // namespace planish
