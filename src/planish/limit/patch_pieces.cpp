#include "planish/limit/patch_pieces.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace planish {
namespace {

constexpr std::size_t kUsualHalvings = 8;  // of a quarter that is searched

// The point of a polynomial in its own square.
PatchPoint bezier_point(const BezierNet& net, double u, double v) {
  std::array<glm::dvec3, 3> value, slope, second;
  for (std::size_t j = 0; j < 3; ++j) {
    const glm::dvec3 &a = net[3 * j], &b = net[3 * j + 1], &c = net[3 * j + 2];
    const glm::dvec3 ab = b - a, bc = c - b, turn = bc - ab;
    slope[j] = 2.0 * (ab + u * turn);
    second[j] = 2.0 * turn;
    value[j] = a + u * (2.0 * ab + u * turn);
  }
  const auto along_v = [v](const std::array<glm::dvec3, 3>& p) {
    const glm::dvec3 ab = p[1] - p[0];
    return p[0] + v * (2.0 * ab + v * (p[2] - p[1] - ab));
  };
  const auto slope_v = [v](const std::array<glm::dvec3, 3>& p) {
    const glm::dvec3 ab = p[1] - p[0];
    return 2.0 * (ab + v * (p[2] - p[1] - ab));
  };
  PatchPoint point;
  point.position = along_v(value);
  point.du = along_v(slope);
  point.dv = slope_v(value);
  point.duu = along_v(second);
  point.duv = slope_v(slope);
  point.dvv = 2.0 * (value[2] - 2.0 * value[1] + value[0]);
  return point;
}

}  // namespace

PatchPoint PatchPiece::at(double own_u, double own_v) const {
  return bezier_point(net, own_u, own_v);
}

double PatchPiece::least_distance(const glm::dvec3& point) const {
  const glm::dvec3 way = net[4] - point;
  const double length = glm::length(way);
  if (!(length > 0)) return 0;
  double least = std::numeric_limits<double>::infinity();
  for (const glm::dvec3& p : net) least = std::min(least, glm::dot(p - point, way));
  return std::max(0.0, least / length);
}

PatchBox PatchPiece::box() const { return box_of(net); }

PatchPiece PatchPiece::half(bool upper_u, bool upper_v) const {
  return {net_quarter(net, upper_u, upper_v), frame.half(upper_u, upper_v)};
}

void PatchPieces::move_to(std::int32_t corner) {
  if (corner == at_) return;
  at_ = corner;
  corner_.move_to(corner);
  const PatchForm& form = corner_.form();
  if (form.is_polynomial()) {
    const PatchPiece whole{bezier_net(form, corner_.points()), {}};
    has_piece_.fill(true);
    for (std::size_t q = 0; q < 4; ++q) {
      pieces_[q] = whole.half(q == 1 || q == 2, q >= 2);
      boxes_[q] = pieces_[q].box();
    }
    return;
  }
  for (std::size_t q = 0; q < 4; ++q) {
    const PatchForm& inner = *form.quarters[q];
    has_piece_[q] = inner.is_polynomial();
    if (has_piece_[q]) {
      quarter_points(form, static_cast<int>(q), corner_.points(), points_);
      pieces_[q].frame = PatchFrame().quarter(static_cast<int>(q));
      pieces_[q].net = bezier_net(inner, points_);
      boxes_[q] = pieces_[q].box();
    } else {
      enter(q, inner);
      boxes_[q] = box_around(inside_[q].points, reaches_.of(inner));
    }
  }
}

void PatchPieces::enter(std::size_t quarter, const PatchForm& form) {
  Inside& inside = inside_[quarter];
  inside.rings.clear();
  inside.rings.reserve(kUsualHalvings);
  inside.form = &form;
  inside.frame = vertex_frame(quarter);
  quarter_points(corner_.form(), static_cast<int>(quarter), corner_.points(), inside.points);
  inside.vertex = glm::dvec3(0.0);
  for (std::size_t k = 0; k < inside.points.size(); ++k)
    inside.vertex += form.corner[k] * inside.points[k];
}

const PatchRing* PatchPieces::ring(std::size_t quarter, std::size_t halving) {
  Inside& inside = inside_[quarter];
  if (halving >= static_cast<std::size_t>(corner_.form().quarters[quarter]->halvings))
    return nullptr;
  while (inside.rings.size() <= halving) {
    PatchRing& ring = inside.rings.emplace_back();
    for (int q = 1; q < 4; ++q) {
      const auto at = static_cast<std::size_t>(q - 1);
      quarter_points(*inside.form, q, inside.points, points_);
      ring.pieces[at].net = bezier_net(*inside.form->quarters[q], points_);
      ring.pieces[at].frame = inside.frame.quarter(q);
      ring.boxes[at] = ring.pieces[at].box();
    }
    quarter_points(*inside.form, 0, inside.points, points_);
    std::swap(inside.points, points_);
    inside.form = inside.form->quarters[0];
    inside.frame = inside.frame.quarter(0);
    ring.rest = box_around(inside.points, reaches_.of(*inside.form));
  }
  return &inside.rings[halving];
}

}  // namespace planish
