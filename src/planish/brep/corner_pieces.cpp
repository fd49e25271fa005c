#include "planish/brep/corner_pieces.h"

#include <array>
#include <cmath>

namespace planish {

double CapBasis::limit_blossom(double t, const BlossomArguments& arguments) const {
  if (t >= 1) return 0;
  double product = 1;
  for (std::size_t a = 0; a < degree_; ++a) product *= 1 - arguments[a];
  return product;
}

double CapBasis::beside_blossom(double t, const BlossomArguments& arguments) const {
  if (t < 1) {
    constexpr std::array<double, kMostSplineDegree + 1> kPoints{0, 1, 0.5, 0.25};
    return bezier_blossom(kPoints.data(), degree_, arguments);
  }
  if (t >= 2) return 0;
  double product = last_;
  for (std::size_t a = 0; a < degree_; ++a) product *= 2 - arguments[a];
  return product;
}

void CapBasis::add_move(const CapMove& move, double x, double y, double size, PointNet& net) const {
  for (std::size_t j = 0; j <= degree_; ++j) {
    const BlossomArguments at_y = bezier_arguments(degree_, j, y, y + size);
    const double y0 = limit_blossom(y, at_y), y1 = beside_blossom(y, at_y);
    for (std::size_t i = 0; i <= degree_; ++i) {
      const BlossomArguments at_x = bezier_arguments(degree_, i, x, x + size);
      const double x0 = limit_blossom(x, at_x), x1 = beside_blossom(x, at_x);
      net[i + (degree_ + 1) * j] +=
          x1 * y0 * move.along_x + x0 * y1 * move.along_y + x1 * y1 * move.inside;
    }
  }
}

CornerPieces::CornerPieces(SplinePatch& patch, std::size_t degree, const std::array<int, 2>& depths)
    : degree_(degree) {
  std::vector<SplinePatch::End> ends;
  patch.add_pieces(depths, pieces_, ends);
  for (const SplinePatch::End& end : ends) add_cap(end, depths[end.is_face ? 1 : 0]);
}

void CornerPieces::add_cap(const SplinePatch::End& end, int depth) {
  // The end's place, the innermost square's far sides, and the polynomials across these.
  const double at = end.is_face ? 1 : 0, size = std::ldexp(1.0, -depth);
  const double inwards = end.is_face ? -size : size, far = at + inwards;
  const SquarePiece& beside_u = this->at(at + 1.5 * inwards, at + 0.5 * inwards);
  const SquarePiece& beside_v = this->at(at + 0.5 * inwards, at + 1.5 * inwards);
  SquarePiece cap;
  cap.u = cap.v = end.is_face ? 1 - size : 0;
  cap.size = size;
  cap.degree = degree_;
  for (std::size_t j = 0; j <= degree_; ++j) {
    for (std::size_t i = 0; i <= degree_; ++i) {
      const std::size_t k = i + (degree_ + 1) * j;
      cap.net[end.is_face ? cap.net_size() - 1 - k : k] =
          k == 0 ? end.limit
                 : (j > i ? beside_v : beside_u)
                       .blossom(bezier_arguments(degree_, i, at, far),
                                bezier_arguments(degree_, j, at, far));
    }
  }
  pieces_.push_back(cap);
}

void CornerPieces::move(const CapMove& move, bool is_face, int depth) {
  const double scale = std::ldexp(1.0, depth);
  const CapBasis basis(degree_);
  for (SquarePiece& piece : pieces_) {
    const double x = scale * (is_face ? 1 - piece.u - piece.size : piece.u);
    const double y = scale * (is_face ? 1 - piece.v - piece.size : piece.v);
    if (x >= 2 || y >= 2) continue;
    PointNet by{};
    basis.add_move(move, x, y, scale * piece.size, by);
    const std::size_t count = piece.net_size();
    for (std::size_t k = 0; k < count; ++k) piece.net[k] += by[is_face ? count - 1 - k : k];
  }
}

const SquarePiece& CornerPieces::at(double u, double v) const {
  for (const SquarePiece& piece : pieces_) {
    if (piece.holds(u, v)) return piece;
  }
  return pieces_.front();
}

}  // namespace planish
