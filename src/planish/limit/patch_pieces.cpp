#include "planish/limit/patch_pieces.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace planish {
namespace {

// Quarters 0 to 3 of a form (at V, E1, F and E2) as places a + 2 b.
constexpr std::array<std::size_t, 4> kPlaceOfQuarter{0, 1, 3, 2};

// A quarter's own Bezier points as the patch sees them: quarter q is turned by q quarter turns.
BezierNet in_patch_directions(const BezierNet& net, int turns) {
  BezierNet result;
  for (std::size_t j = 0; j < 3; ++j) {
    for (std::size_t i = 0; i < 3; ++i) {
      std::size_t a = i, b = j;
      for (int k = 0; k < turns; ++k) {
        const std::size_t before = a;
        a = b;
        b = 2 - before;
      }
      result[i + 3 * j] = net[a + 3 * b];
    }
  }
  return result;
}

PatchBox box_of(std::span<const glm::dvec3> points) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  PatchBox box{glm::dvec3(kFar), glm::dvec3(-kFar)};
  for (const glm::dvec3& p : points) box.add(p);
  return box;
}

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

void PatchPieces::move_to(std::int32_t corner, const PatchReaches& reaches) {
  corner_.move_to(corner);
  const PatchForm& form = corner_.form();
  is_polynomial_ = form.is_polynomial();
  if (is_polynomial_) {
    bezier_points(form, corner_.points(), whole_);
    for (std::size_t q = 0; q < 4; ++q) {
      has_net_[q] = true;
      nets_[q] = whole_;
      bezier_quarter(nets_[q], q % 2 == 1, q >= 2);
      boxes_[q] = box_of(nets_[q]);
    }
    return;
  }
  for (int q = 0; q < 4; ++q) {
    const std::size_t place = kPlaceOfQuarter[static_cast<std::size_t>(q)];
    const PatchForm& inner = *form.quarters[static_cast<std::size_t>(q)];
    quarter_points(form, q, corner_.points(), points_);
    has_net_[place] = inner.is_polynomial();
    if (has_net_[place]) {
      BezierNet net;
      bezier_points(inner, points_, net);
      nets_[place] = in_patch_directions(net, q);
      boxes_[place] = box_of(net);
      continue;
    }
    PatchBox box = box_of(points_);
    const glm::dvec3 middle = 0.5 * (box.low + box.high);
    const glm::dvec3 half = 0.5 * reaches.of(inner) * (box.high - box.low);
    boxes_[place] = {middle - half, middle + half};
  }
}

PatchPoint PatchPieces::at(double u, double v) {
  if (is_polynomial_) {
    PatchPoint point = bezier_point(whole_, u, v);
    point.position += corner_.own();
    return point;
  }
  const double a = u < 0.5 ? 0 : 1, b = v < 0.5 ? 0 : 1;
  const auto place = static_cast<std::size_t>(a + 2 * b);
  if (!has_net_[place]) return corner_.at({u, v});
  PatchPoint point = bezier_point(nets_[place], 2 * u - a, 2 * v - b);
  point.position += corner_.own();
  point.du *= 2.0;
  point.dv *= 2.0;
  point.duu *= 4.0;
  point.duv *= 4.0;
  point.dvv *= 4.0;
  return point;
}

double PatchPieces::least_distance(std::size_t quarter, const glm::dvec3& point) const {
  if (!has_net_[quarter]) return 0;
  const BezierNet& net = nets_[quarter];
  const glm::dvec3 way = net[4] - point;
  const double length = glm::length(way);
  if (!(length > 0)) return 0;
  double least = std::numeric_limits<double>::infinity();
  for (const glm::dvec3& p : net) least = std::min(least, glm::dot(p - point, way));
  return std::max(0.0, least / length);
}

}  // namespace planish
