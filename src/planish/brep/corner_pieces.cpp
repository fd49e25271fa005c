#include "planish/brep/corner_pieces.h"

#include <array>
#include <cmath>

#include "planish/core/assert.h"
#include "planish/limit/patch_box.h"
#include "planish/limit/patch_pieces.h"

namespace planish {
namespace {

// A polynomial of a frame, as the patch around it sees it.
SquarePiece in_patch(const PatchFrame& frame, const BezierNet& net, const glm::dvec3& own) {
  const glm::dvec2 a = frame.at(0, 0), b = frame.at(1, 1);
  SquarePiece piece;
  piece.u = std::min(a.x, b.x);
  piece.v = std::min(a.y, b.y);
  piece.size = frame.size;
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 3; ++i) {
      const double du = (piece.u - frame.u) / frame.size + 0.5 * i;
      const double dv = (piece.v - frame.v) / frame.size + 0.5 * j;
      const auto x = static_cast<std::size_t>(std::lround(2 * (frame.c * du + frame.s * dv)));
      const auto y = static_cast<std::size_t>(std::lround(2 * (frame.c * dv - frame.s * du)));
      piece.net[static_cast<std::size_t>(i + 3 * j)] = own + net[x + 3 * y];
    }
  }
  return piece;
}

// Blossoms of the two basis functions on knots 0, 0, 0, 1, 2, by the square that holds the place.
double first_blossom(int square, double s, double t) { return square == 0 ? (1 - s) * (1 - t) : 0; }
double second_blossom(int square, double s, double t) {
  if (square == 0) return s + t - 1.5 * s * t;
  return square == 1 ? 0.5 * (2 - s) * (2 - t) : 0;
}

}  // namespace

double move_basis(double x) { return second_blossom(static_cast<int>(x), x, x); }

glm::dvec3 moved_by(const CapMove& move, double x, double y) {
  const double x1 = move_basis(x), y1 = move_basis(y);
  return x1 * first_blossom(static_cast<int>(y), y, y) * move.along_x +
         first_blossom(static_cast<int>(x), x, x) * y1 * move.along_y + x1 * y1 * move.inside;
}

void add_move(const CapMove& move, double x, double y, double size, BezierNet& net) {
  const int square_x = static_cast<int>(x), square_y = static_cast<int>(y);
  for (std::size_t j = 0; j < 3; ++j) {
    const double low_y = j < 2 ? y : y + size, high_y = j > 0 ? y + size : y;
    const double y0 = first_blossom(square_y, low_y, high_y);
    const double y1 = second_blossom(square_y, low_y, high_y);
    for (std::size_t i = 0; i < 3; ++i) {
      const double low_x = i < 2 ? x : x + size, high_x = i > 0 ? x + size : x;
      const double x0 = first_blossom(square_x, low_x, high_x);
      const double x1 = second_blossom(square_x, low_x, high_x);
      net[i + 3 * j] += x1 * y0 * move.along_x + x0 * y1 * move.along_y + x1 * y1 * move.inside;
    }
  }
}

glm::dvec3 SquarePiece::blossom(BlossomPair along_u, BlossomPair along_v) const {
  const double s = (along_u.first - u) / size, t = (along_u.second - u) / size;
  std::array<glm::dvec3, 3> row;
  for (std::size_t j = 0; j < 3; ++j)
    row[j] = quadratic_blossom(net[3 * j], net[3 * j + 1], net[3 * j + 2], s, t);
  return quadratic_blossom(row[0], row[1], row[2], (along_v.first - v) / size,
                           (along_v.second - v) / size);
}

CornerPieces::CornerPieces(LimitSurface::Corner& corner, int depth_at_vertex, int depth_at_face)
    : own_(corner.own()) {
  const PatchForm& form = corner.form();
  BezierNet net;
  if (form.is_polynomial()) {
    bezier_points(form, corner.points(), net);
    pieces_.push_back(in_patch({}, net, own_));
    return;
  }
  std::array<std::vector<glm::dvec3>, 4> points;
  for (const int q : {1, 3, 0, 2}) {
    const auto index = static_cast<std::size_t>(q);
    quarter_points(form, q, corner.points(), points[index]);
    const PatchForm& inner = *form.quarters[index];
    if (inner.is_polynomial()) {
      bezier_points(inner, points[index], net);
      pieces_.push_back(in_patch(PatchFrame().quarter(q), net, own_));
    } else {
      PLANISH_ASSERT(q == 0 || q == 2);
      add_end(inner, std::move(points[index]), q, q == 0 ? depth_at_vertex : depth_at_face);
    }
  }
}

void CornerPieces::add_end(const PatchForm& end, std::vector<glm::dvec3> points, int quarter,
                           int depth) {
  const PatchForm* form = &end;
  PatchFrame frame = PatchFrame().quarter(quarter);
  std::vector<glm::dvec3> next;
  BezierNet net;
  for (int d = 1; d < depth; ++d) {
    for (int q = 1; q < 4; ++q) {
      quarter_points(*form, q, points, next);
      bezier_points(*form->quarters[static_cast<std::size_t>(q)], next, net);
      pieces_.push_back(in_patch(frame.quarter(q), net, own_));
    }
    quarter_points(*form, 0, points, next);
    std::swap(points, next);
    form = form->quarters[0];
    frame = frame.quarter(0);
  }
  glm::dvec3 limit = own_;
  for (std::size_t k = 0; k < points.size(); ++k) limit += form->corner[k] * points[k];

  // The end's place, the innermost square's far sides, and the polynomials across these.
  const double at = quarter == 0 ? 0 : 1, size = frame.size;
  const double inwards = quarter == 0 ? size : -size, far = at + inwards;
  const SquarePiece& beside_u = this->at(at + 1.5 * inwards, at + 0.5 * inwards);
  const SquarePiece& beside_v = this->at(at + 0.5 * inwards, at + 1.5 * inwards);
  const std::array<BlossomPair, 3> pairs{{{at, at}, {at, far}, {far, far}}};
  SquarePiece cap;
  cap.u = cap.v = quarter == 0 ? 0 : 1 - size;
  cap.size = size;
  for (std::size_t j = 0; j < 3; ++j) {
    for (std::size_t i = 0; i < 3; ++i) {
      const SquarePiece& beside = j > i ? beside_v : beside_u;
      const std::size_t place = quarter == 0 ? i + 3 * j : 8 - (i + 3 * j);
      cap.net[place] = i + j == 0 ? limit : beside.blossom(pairs[i], pairs[j]);
    }
  }
  pieces_.push_back(cap);
}

void CornerPieces::move(const CapMove& move, bool is_face, int depth) {
  const double scale = std::ldexp(1.0, depth);
  for (SquarePiece& piece : pieces_) {
    const double x = scale * (is_face ? 1 - piece.u - piece.size : piece.u);
    const double y = scale * (is_face ? 1 - piece.v - piece.size : piece.v);
    if (x >= 2 || y >= 2) continue;
    BezierNet by{};
    add_move(move, x, y, scale * piece.size, by);
    for (std::size_t k = 0; k < 9; ++k) piece.net[k] += by[is_face ? 8 - k : k];
  }
}

const SquarePiece& CornerPieces::at(double u, double v) const {
  for (const SquarePiece& piece : pieces_) {
    if (piece.holds(u, v)) return piece;
  }
  return pieces_.front();
}

}  // namespace planish
