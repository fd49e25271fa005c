#include "planish/queries/closest_point.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <utility>

#include "planish/core/portable_math.h"
#include "planish/core/vectors.h"
#include "planish/patches/bezier_net.h"
#include "planish/patches/patch_form.h"

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

namespace {

// Of a coefficient, and of differences of some: far above what is lost.
constexpr double kCoefficientRounding = 4e-15;

constexpr std::array<double, 3> kQuadratic = {1, 2, 1};  // binomial coefficients
constexpr std::array<double, 5> kQuartic = {1, 4, 6, 4, 1};

}  // namespace

// The square of a point's distance from a piece, a polynomial of degree 4 along u and along v, by
// its Bernstein coefficients: they bound it and its derivatives over the piece's whole square.
class DistanceNet {
 public:
  DistanceNet(const BezierNet& net, const glm::dvec3& point);

  // No place's is less, but for rounding.
  [[nodiscard]] double least() const { return *std::ranges::min_element(values_); }
  [[nodiscard]] double largest() const { return *std::ranges::max_element(values_); }
  // Where along u and v, of 0 to 1, the least coefficient stands.
  [[nodiscard]] std::array<double, 2> place_of_least() const;
  // The least at the square's corners, which are places.
  [[nodiscard]] double least_at_corners() const;

  // 1 where it surely rises along a direction all over the square, -1 where it falls; else 0.
  [[nodiscard]] int slope(bool along_v) const;
  // Whether it surely is convex, along one direction or over the square.
  [[nodiscard]] bool is_convex_along(bool along_v) const;
  [[nodiscard]] bool is_convex() const;
  // Whether it bends more along v than along u.
  [[nodiscard]] bool bends_more_along_v() const;

  // That of one half of the square.
  [[nodiscard]] DistanceNet half(bool along_v, bool upper) const;
  // Of the border at 0 or, `upper`, at 1: constant along the direction.
  [[nodiscard]] DistanceNet border(bool along_v, bool upper) const;

 private:
  static constexpr std::size_t kSide = 5;
  // The least and the largest in magnitude of the second differences along a direction.
  struct Bend {
    double least, most;
  };
  [[nodiscard]] Bend bend(bool along_v) const;
  [[nodiscard]] double rounding() const;

  std::array<double, kSide * kSide> values_{};  // (i, j) at i + 5 j
};

// The product of two Bernstein polynomials: coefficients times binomial coefficients multiply like
// those of powers.
DistanceNet::DistanceNet(const BezierNet& net, const glm::dvec3& point) {
  BezierNet off;
  for (std::size_t j = 0; j < 3; ++j)
    for (std::size_t i = 0; i < 3; ++i)
      off[i + 3 * j] = kQuadratic[i] * kQuadratic[j] * (net[i + 3 * j] - point);
  for (std::size_t a = 0; a < 9; ++a) {
    const std::size_t i = a % 3, j = a / 3;
    values_[2 * i + kSide * 2 * j] += glm::dot(off[a], off[a]);
    for (std::size_t b = a + 1; b < 9; ++b)
      values_[i + b % 3 + kSide * (j + b / 3)] += 2 * glm::dot(off[a], off[b]);
  }
  for (std::size_t j = 0; j < kSide; ++j)
    for (std::size_t i = 0; i < kSide; ++i) values_[i + kSide * j] /= kQuartic[i] * kQuartic[j];
}

std::array<double, 2> DistanceNet::place_of_least() const {
  const auto at = static_cast<std::size_t>(std::ranges::min_element(values_) - values_.begin());
  constexpr double kLast = kSide - 1;
  return {static_cast<double>(at % kSide) / kLast, static_cast<double>(at / kSide) / kLast};
}

double DistanceNet::least_at_corners() const {
  return std::min({values_[0], values_[kSide - 1], values_[kSide * (kSide - 1)], values_.back()});
}

double DistanceNet::rounding() const { return kCoefficientRounding * largest(); }

int DistanceNet::slope(bool along_v) const {
  const std::size_t step = along_v ? kSide : 1, across = along_v ? 1 : kSide;
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (std::size_t k = 0; k < kSide; ++k) {
    for (std::size_t i = 0; i + 1 < kSide; ++i) {
      const double rise = values_[k * across + (i + 1) * step] - values_[k * across + i * step];
      least = std::min(least, rise);
      most = std::max(most, rise);
    }
  }
  if (least > rounding()) return 1;
  return most < -rounding() ? -1 : 0;
}

DistanceNet::Bend DistanceNet::bend(bool along_v) const {
  const std::size_t step = along_v ? kSide : 1, across = along_v ? 1 : kSide;
  Bend bend{std::numeric_limits<double>::infinity(), 0};
  for (std::size_t k = 0; k < kSide; ++k) {
    for (std::size_t i = 0; i + 2 < kSide; ++i) {
      const double* const at = &values_[k * across + i * step];
      const double second = at[0] - 2 * at[step] + at[2 * step];
      bend.least = std::min(bend.least, second);
      bend.most = std::max(bend.most, std::abs(second));
    }
  }
  return bend;
}

bool DistanceNet::is_convex_along(bool along_v) const { return bend(along_v).least > rounding(); }

// The Hessian's diagonal from below and the other entry by magnitude: 12, 12 and 16 times the
// differences.
bool DistanceNet::is_convex() const {
  const double uu = bend(false).least, vv = bend(true).least, lost = rounding();
  if (!(uu > lost) || !(vv > lost)) return false;
  double mixed = 0;
  for (std::size_t j = 0; j + 1 < kSide; ++j) {
    for (std::size_t i = 0; i + 1 < kSide; ++i) {
      const double* const at = &values_[i + kSide * j];
      mixed = std::max(mixed, std::abs(at[kSide + 1] - at[kSide] - at[1] + at[0]));
    }
  }
  return 144 * (uu - lost) * (vv - lost) > 256 * (mixed + lost) * (mixed + lost);
}

bool DistanceNet::bends_more_along_v() const { return bend(true).most > bend(false).most; }

// De Casteljau's midpoints.
DistanceNet DistanceNet::half(bool along_v, bool upper) const {
  DistanceNet result(*this);
  const std::size_t step = along_v ? kSide : 1, across = along_v ? 1 : kSide;
  for (std::size_t k = 0; k < kSide; ++k) {
    double* const line = &result.values_[k * across];
    for (std::size_t round = 1; round < kSide; ++round) {
      for (std::size_t i = 0; i + round < kSide; ++i) {
        // From the end that stays outwards.
        const std::size_t at = upper ? i : kSide - 1 - i;
        double& value = line[at * step];
        value = 0.5 * (value + line[(upper ? at + 1 : at - 1) * step]);
      }
    }
  }
  return result;
}

DistanceNet DistanceNet::border(bool along_v, bool upper) const {
  DistanceNet result(*this);
  const std::size_t step = along_v ? kSide : 1, across = along_v ? 1 : kSide;
  for (std::size_t k = 0; k < kSide; ++k) {
    const double value = values_[k * across + (upper ? kSide - 1 : 0) * step];
    for (std::size_t i = 0; i < kSide; ++i) result.values_[k * across + i * step] = value;
  }
  return result;
}

namespace {

// A part of a polynomial as a sheet over the plane that touches it in its middle, about a point:
// what tells how near the point it comes, however long and thin it is and however aslant its
// parameters run. (The square distance by parameters has a valley there that bends, and is convex
// in no region wider than the valley.)
class SheetBound {
 public:
  SheetBound(const BezierNet& net, const glm::dvec3& point);

  // No place of the part is nearer to the point, but for rounding: by a box that lies along it.
  [[nodiscard]] double least_distance() const;
  // Whether the part, continued by half its size on all sides, has one place at most where the
  // distance falls no further, and none of the part is nearer than this. By the heights over the
  // plane: the square distance is convex over a convex part of the plane that holds the part.
  [[nodiscard]] bool has_one_nearest();
  // Whether a place of the continued part, relative to the point, lies over that convex part.
  // Asked after has_one_nearest().
  [[nodiscard]] bool is_over_convex_part(const glm::dvec3& place) const;
  // The square distance of no place of the part is less, by that of one of it, relative to the
  // point, and how it rises and falls from there. Asked after has_one_nearest(), too.
  [[nodiscard]] double least_square(const PatchPoint& place) const;

 private:
  BezierNet net_;    // along axes_, about the point
  glm::dmat3 axes_;  // its columns: along the part, across it, off it
  glm::dvec2 middle_{0.0};
  std::array<glm::dvec2, 2> to_parameters_{};  // rows: of places of the plane
  double reach_ = 0;  // of the convex part from the middle, in parameters of the continued part
};

// Of matrices of 2 x 2: by rows; symmetric ones by (00, 01, 11).
using Matrix = std::array<glm::dvec2, 2>;
using Symmetric = glm::dvec3;

// Up to this the parameters of the plane differ from those of the part, of these. The part
// continued by half then covers 2 (1 - t) / (1 + t) >= 1 of what the part can at most.
constexpr double kMostBent = 1.0 / 3;

// Of the square of its sides: a narrower part is a line to rounding.
constexpr double kLeastArea = 1e-12;

glm::dvec2 product(const Matrix& m, const glm::dvec2& p) {
  return {glm::dot(m[0], p), glm::dot(m[1], p)};
}

// The least and the largest of some values, by their middle and half their difference.
struct Span {
  double low = HUGE_VAL, high = -HUGE_VAL;

  void add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  [[nodiscard]] double middle() const { return 0.5 * (low + high); }
  [[nodiscard]] double half() const { return 0.5 * (high - low); }
  [[nodiscard]] double size() const { return std::max(std::abs(low), std::abs(high)); }
};

// Bernstein coefficients of derivatives.
using Firsts = std::array<glm::dvec3, 6>;

Firsts along_u(const BezierNet& net) {
  Firsts result;
  for (std::size_t i = 0; i < 6; ++i) {
    const std::size_t at = i % 2 + 3 * (i / 2);
    result[i] = 2.0 * (net[at + 1] - net[at]);
  }
  return result;
}

Firsts along_v(const BezierNet& net) {
  Firsts result;
  for (std::size_t i = 0; i < 6; ++i) result[i] = 2.0 * (net[i + 3] - net[i]);
  return result;
}

// By Bernstein polynomials at 1/2: of degree 1 along u, and 2 along v, as along_u() has them, or
// the other way round.
glm::dvec3 in_middle(const Firsts& f, bool is_along_v) {
  return is_along_v ? 0.125 * (f[0] + 2.0 * f[1] + f[2] + f[3] + 2.0 * f[4] + f[5])
                    : 0.125 * (f[0] + f[1] + 2.0 * (f[2] + f[3]) + f[4] + f[5]);
}

// Heights' and plane parameters' second derivatives along uu, uv or vv.
struct Seconds {
  Span height;
  glm::dvec2 sideways{0.0};  // by magnitude

  void add(const glm::dvec3& second, const Matrix& to_parameters) {
    height.add(second.z);
    sideways = glm::max(sideways, glm::abs(product(to_parameters, glm::dvec2(second))));
  }
};

std::array<Seconds, 3> seconds_of(const BezierNet& p, const Matrix& to_parameters) {
  std::array<Seconds, 3> result;
  for (std::size_t k = 0; k < 3; ++k) {
    result[0].add(2.0 * (p[3 * k + 2] - 2.0 * p[3 * k + 1] + p[3 * k]), to_parameters);
    result[2].add(2.0 * (p[6 + k] - 2.0 * p[3 + k] + p[k]), to_parameters);
  }
  for (const std::size_t at : {0, 1, 3, 4})
    result[1].add(4.0 * (p[at + 4] - p[at + 3] - p[at + 1] + p[at]), to_parameters);
  return result;
}

// F^t W F + F^t W + W F of matrices without negative entries.
Symmetric spread(const Symmetric& w, const Matrix& f) {
  const Matrix one = {glm::dvec2(1 + f[0].x, f[0].y), glm::dvec2(f[1].x, 1 + f[1].y)};
  const auto entry = [&](int i, int j) {
    return one[0][i] * (w.x * one[0][j] + w.y * one[1][j]) +
           one[1][i] * (w.y * one[0][j] + w.z * one[1][j]);
  };
  return Symmetric(entry(0, 0), entry(0, 1), entry(1, 1)) - w;
}

SheetBound::SheetBound(const BezierNet& net, const glm::dvec3& point) {
  const glm::dvec3 du = in_middle(planish::along_u(net), false);
  const glm::dvec3 dv = in_middle(planish::along_v(net), true);
  const glm::dvec3 along = unit_or_zero(glm::dot(du, du) >= glm::dot(dv, dv) ? du : dv);
  const glm::dvec3 off = unit_or_zero(glm::cross(du, dv));
  const bool has_plane = along != glm::dvec3(0.0) && off != glm::dvec3(0.0);
  axes_ = has_plane ? glm::dmat3(along, glm::cross(off, along), off) : glm::dmat3(1.0);
  for (std::size_t i = 0; i < 9; ++i) net_[i] = (net[i] - point) * axes_;
}

double SheetBound::least_distance() const {
  return std::sqrt(square_distance(box_of(net_), glm::dvec3(0.0)));
}

bool SheetBound::has_one_nearest() {
  const BezierNet wide = net_between(net_between(net_, true, -0.5, 1.5), false, -0.5, 1.5);
  const Firsts su = planish::along_u(wide), sv = planish::along_v(wide);
  const glm::dvec2 du(in_middle(su, false)), dv(in_middle(sv, true));
  const double det = du.x * dv.y - du.y * dv.x;
  if (!(std::abs(det) > kLeastArea * (glm::dot(du, du) + glm::dot(dv, dv)))) return false;
  to_parameters_ = {glm::dvec2(dv.y, -dv.x) / det, glm::dvec2(-du.y, du.x) / det};

  // How parameters of the plane run along those of the part: 1 and what is below.
  Matrix bent{};
  glm::dvec2 slope(0.0);  // of heights, by magnitude
  for (std::size_t i = 0; i < 6; ++i) {
    const glm::dvec2 u = glm::abs(product(to_parameters_, glm::dvec2(su[i])) - glm::dvec2(1, 0));
    const glm::dvec2 v = glm::abs(product(to_parameters_, glm::dvec2(sv[i])) - glm::dvec2(0, 1));
    bent = {glm::max(bent[0], glm::dvec2(u.x, v.x)), glm::max(bent[1], glm::dvec2(u.y, v.y))};
    slope = glm::max(slope, glm::dvec2(std::abs(su[i].z), std::abs(sv[i].z)));
  }
  const double most = std::max(bent[0].x + bent[0].y, bent[1].x + bent[1].y);
  if (!(most <= kMostBent)) return false;  // NaN too
  reach_ = 0.5 * (1 - most);
  const BezierNet& w = wide;
  middle_ =
      glm::dvec2(w[0] + w[2] + w[6] + w[8] + 2.0 * (w[1] + w[3] + w[5] + w[7]) + 4.0 * w[4]) / 16.0;

  // The inverse, 1 and what is below: the sum of the powers.
  const double rest = (1 - bent[0].x) * (1 - bent[1].y) - bent[0].y * bent[1].x;
  const Matrix back = {glm::dvec2((1 - bent[1].y) / rest - 1, bent[0].y / rest),
                       glm::dvec2(bent[1].x / rest, (1 - bent[0].x) / rest - 1)};
  slope += glm::dvec2(slope.x * back[0].x + slope.y * back[1].x,
                      slope.x * back[0].y + slope.y * back[1].y);

  // Heights' second derivatives by parameters of the plane: their middle, and what they may be off.
  Symmetric middle(0.0), margin(0.0);
  const std::array<Seconds, 3> seconds = seconds_of(wide, to_parameters_);
  for (int k = 0; k < 3; ++k) {
    middle[k] = seconds[k].height.middle();
    margin[k] = seconds[k].height.half() + glm::dot(slope, seconds[k].sideways);
  }
  margin += spread(glm::abs(middle) + margin, back);

  Span height;
  for (const glm::dvec3& p : wide) height.add(p.z);
  const double own = height.middle();
  const Symmetric hessian =
      Symmetric(glm::dot(du, du), glm::dot(du, dv), glm::dot(dv, dv)) + own * middle;
  const Symmetric lost = std::abs(own) * margin + height.half() * (glm::abs(middle) + margin);
  // That of half the square distance, without the square of the slope, which only adds to it.
  const double first = hessian.x - lost.x, last = hessian.z - lost.z;
  const double mixed = std::abs(hessian.y) + lost.y;
  return first > 0 && last > 0 && first * last * (1 - 1e-12) > mixed * mixed;
}

bool SheetBound::is_over_convex_part(const glm::dvec3& place) const {
  const glm::dvec2 at = product(to_parameters_, glm::dvec2(place * axes_) - middle_);
  return std::max(std::abs(at.x), std::abs(at.y)) <= reach_;
}

// A convex function lies above its tangents.
double SheetBound::least_square(const PatchPoint& place) const {
  const glm::dvec3 at = place.position * axes_;
  const glm::dvec2 du(place.du * axes_), dv(place.dv * axes_);
  const double gu = glm::dot(place.position, place.du), gv = glm::dot(place.position, place.dv);
  const double det = du.x * dv.y - du.y * dv.x;
  const glm::dvec2 rise = glm::dvec2(gu * dv.y - gv * du.y, gv * du.x - gu * dv.x) / det;
  double least = HUGE_VAL;
  for (const glm::dvec3& p : net_) least = std::min(least, glm::dot(rise, glm::dvec2(p - at)));
  return glm::dot(at, at) + 2 * least;
}

constexpr int kMostDescents = 100;
constexpr double kSmallStep = 1e-14;     // in u and v
constexpr double kSmallestShare = 1e-7;  // of a step
constexpr double kLeastBend = 2e-6;      // what second derivatives along a way of 1 count for
constexpr double kBorder = 1e-12;        // of a region: on the border
// What an answer may be too far by: in unit coordinates, and of the distance.
constexpr double kAbsolute = 1e-13, kRelative = 2e-15;
// Regions that are searched before an answer may be too far by ten times as much: hundreds are
// common. Over faces that are lines but for 1e-12 of their length, whole curves of places are as
// near as one another, and cutting along u and v would follow them in steps of their width.
constexpr std::int64_t kPatience = 1 << 17;
// What a bound may be wrong by, of the largest square distance that it was made of.
constexpr double kBoundRounding = 2e-15;
// A bound is made again where it lost so much of that.
constexpr double kWorn = 1.0 / 8;

// By how much less the square of a distance does not matter.
double negligible(double square) {
  return 2 * (kAbsolute * std::sqrt(square) + kRelative * square);
}

// No place of a piece moves faster along u or v while that goes from 0 to 1.
double largest_speed(const BezierNet& net, bool along_v) {
  const std::size_t step = along_v ? 3 : 1, across = along_v ? 1 : 3;
  double largest = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t i = 0; i < 2; ++i) {
      const glm::dvec3& from = net[k * across + i * step];
      largest = std::max(largest, glm::length(net[k * across + (i + 1) * step] - from));
    }
  }
  return 2 * largest;
}

// What a step of Newton's method is made of: the square distance, and half its gradient and
// Hessian.
struct Descent {
  double value = 0, gu = 0, gv = 0, huu = 0, huv = 0, hvv = 0;
  double e = 0, f = 0, g = 0, area = 0;  // of the tangents: their products, and the area they span

  Descent(const PatchPoint& p, const glm::dvec3& target) {
    const glm::dvec3 off = p.position - target;
    value = glm::dot(off, off);
    gu = glm::dot(off, p.du);
    gv = glm::dot(off, p.dv);
    e = glm::dot(p.du, p.du);
    f = glm::dot(p.du, p.dv);
    g = glm::dot(p.dv, p.dv);
    area = glm::length(glm::cross(p.du, p.dv));
    huu = e + glm::dot(off, p.duu);
    huv = f + glm::dot(off, p.duv);
    hvv = g + glm::dot(off, p.dvv);
  }

  // Downhill along both, by ways on the surface rather than by parameters, which may run aslant and
  // unevenly. Where the distance is not convex in a direction, its second derivative there counts
  // by magnitude, so that steps lead away from saddles.
  [[nodiscard]] glm::dvec2 step() const {
    // Parameters of a way of 1 along the longer tangent, and of one across it.
    const bool is_u = e >= g;
    const glm::dvec2 first = (is_u ? glm::dvec2(1, 0) : glm::dvec2(0, 1)) / std::sqrt(is_u ? e : g);
    const glm::dvec2 second = across(is_u ? glm::dvec2(-f / e, 1) : glm::dvec2(1, -f / g),
                                     std::max(e, g), std::min(e, g));
    const glm::dvec2 gradient(gu, gv);
    const double g1 = glm::dot(gradient, first), g2 = glm::dot(gradient, second);
    const double h11 = bend(first, first), h12 = bend(first, second), h22 = bend(second, second);
    const double both = h11 * h22 - h12 * h12;
    if (h11 > 0 && both > kLeastBend * (h11 + h22))
      return (h12 * g2 - h22 * g1) / both * first + (h12 * g1 - h11 * g2) / both * second;
    const double middle = 0.5 * (h11 + h22), half = 0.5 * (h11 - h22);
    const double root = portable::hypot(half, h12);
    const double turn = 0.5 * portable::atan2(h12, half);
    const double c = portable::cos(turn), s = portable::sin(turn);
    const double one = -(c * g1 + s * g2) / size(middle + root, 1);
    const double other = -(c * g2 - s * g1) / size(middle - root, 1);
    return (c * one - s * other) * first + (s * one + c * other) * second;
  }
  [[nodiscard]] double step_u() const { return -gu / size(huu, e); }
  [[nodiscard]] double step_v() const { return -gv / size(hvv, g); }

 private:
  // The way across the longer tangent that has such parameters but for its length, by the squares
  // of both tangents. Tangents that are one count as if they were not quite.
  [[nodiscard]] glm::dvec2 across(const glm::dvec2& way, double longer, double shorter) const {
    const double width = std::max(area / std::sqrt(longer), 1e-10 * std::sqrt(shorter));
    return width > 0 ? way / width : glm::dvec2(0.0);
  }
  [[nodiscard]] double bend(const glm::dvec2& a, const glm::dvec2& b) const {
    return a.x * (huu * b.x + huv * b.y) + a.y * (huv * b.x + hvv * b.y);
  }
  // `square`: of the way that the parameter makes.
  static double size(double second, double square) {
    return std::max(std::abs(second), kLeastBend * square);
  }
};

}  // namespace

// A rectangle of a piece's square, and the distance over it. Where an end is fixed both are one.
struct NearestSearch::Region {
  DistanceNet net;
  double made_of;  // the largest square distance when the net was made
  // How far a place moves at most from end to end along u and v.
  std::array<double, 2> extent;
  std::array<double, 2> low{0, 0}, high{1, 1};

  Region(const BezierNet& of, const glm::dvec3& point)
      : net(of, point),
        made_of(net.largest()),
        extent{largest_speed(of, false), largest_speed(of, true)} {}

  [[nodiscard]] bool is_fixed(bool along_v) const { return low[along_v] == high[along_v]; }
  [[nodiscard]] double least() const { return net.least() - kBoundRounding * made_of; }
  [[nodiscard]] bool is_blocked(bool along_v, double t, double gradient) const {
    return (t <= low[along_v] && gradient >= 0) || (t >= high[along_v] && gradient <= 0);
  }
  [[nodiscard]] bool is_left(bool along_v, double t, double step) const {
    return (t <= low[along_v] && step < 0) || (t >= high[along_v] && step > 0);
  }
  [[nodiscard]] bool is_at_border(double u, double v) const {
    return u <= low[0] || u >= high[0] || v <= low[1] || v >= high[1];
  }
  // Where a descent begins.
  [[nodiscard]] glm::dvec2 start() const {
    const auto share = net.place_of_least();
    return {low[0] + share[0] * (high[0] - low[0]), low[1] + share[1] * (high[1] - low[1])};
  }
  // Within it, and on its border where it is as good as there.
  [[nodiscard]] double inside(bool along_v, double t) const {
    const double margin = kBorder * (high[along_v] - low[along_v]);
    if (t < low[along_v] + margin) return low[along_v];
    return t > high[along_v] - margin ? high[along_v] : t;
  }
  [[nodiscard]] BezierNet part_of(const BezierNet& piece) const {
    return net_between(net_between(piece, true, low[1], high[1]), false, low[0], high[0]);
  }
  // By half its size on all sides. The net stays what it was.
  [[nodiscard]] Region continued() const {
    Region wide = *this;
    for (std::size_t d = 0; d < 2; ++d) {
      const double more = 0.5 * (high[d] - low[d]);
      wide.low[d] -= more;
      wide.high[d] += more;
    }
    return wide;
  }
  // Of the same bounds, nearer to what they are now.
  void make_again(const BezierNet& of_piece, const glm::dvec3& point) {
    const Region made(part_of(of_piece), point);
    net = made.net;
    made_of = made.made_of;
    extent = made.extent;
  }
  [[nodiscard]] Region half(bool along_v, bool upper) const {
    Region part = *this;
    part.net = net.half(along_v, upper);
    part.extent[along_v] *= 0.5;
    (upper ? part.low : part.high)[along_v] = 0.5 * (low[along_v] + high[along_v]);
    return part;
  }
  void fix(bool along_v, bool upper) {
    net = net.border(along_v, upper);
    extent[along_v] = 0;
    (upper ? low : high)[along_v] = (upper ? high : low)[along_v];
  }
};

// Where a descent in a region ends, and whether the distance falls no further there, but for what
// is negligible.
struct NearestSearch::Lowest {
  double u, v, value;
  bool is_lowest;
};

// Newton's method in a region: steps end at its borders, and go along them where the distance falls
// outwards. Nothing of the surface bends abruptly on the way.
NearestSearch::Lowest NearestSearch::lowest_in(const PatchPiece& piece, const Region& region,
                                               const glm::dvec2& start, const glm::dvec3& point) {
  double u = start.x, v = start.y;
  Descent here(piece.at(u, v), point);
  bool is_lowest = false;
  for (int step = 0; step < kMostDescents; ++step) {
    const bool fixed_u = region.is_blocked(false, u, here.gu);
    const bool fixed_v = region.is_blocked(true, v, here.gv);
    double du = 0, dv = 0;
    if (!fixed_u && !fixed_v) {
      const glm::dvec2 both = here.step();
      du = both.x;
      dv = both.y;
    } else if (!fixed_u) {
      du = here.step_u();
    } else if (!fixed_v) {
      dv = here.step_v();
    }
    // At a border, along it where the step would leave.
    const bool leaves_u = region.is_left(false, u, du), leaves_v = region.is_left(true, v, dv);
    if (leaves_u) du = 0;
    if (leaves_v) dv = 0;
    if (leaves_u && dv != 0) dv = here.step_v();
    if (leaves_v && du != 0) du = here.step_u();
    is_lowest = -(here.gu * du + here.gv * dv) <= negligible(here.value);
    if (!(std::abs(du) + std::abs(dv) > kSmallStep)) break;  // NaN too: no tangents
    bool falls = false;
    for (double share = 1; share > kSmallestShare && !falls; share *= 0.5) {
      const double next_u = region.inside(false, u + share * du);
      const double next_v = region.inside(true, v + share * dv);
      const Descent next(piece.at(next_u, next_v), point);
      if (!(next.value < here.value)) continue;
      u = next_u;
      v = next_v;
      here = next;
      falls = true;
    }
    if (!falls) break;
  }
  return {u, v, here.value, is_lowest};
}

bool NearestSearch::descend(const PatchPiece& piece, const Region& region,
                            const glm::dvec3& point) {
  const Lowest lowest = lowest_in(piece, region, region.start(), point);
  take(lowest.value, piece.frame.at(lowest.u, lowest.v));
  return lowest.is_lowest;
}

// Whether a region is done with as a sheet: too far, or it has one nearest place at most, which is
// found, or lies beyond the piece: then the region's own is on the piece's border, or beyond a
// border within the piece are nearer ones.
bool NearestSearch::search_sheet(const PatchPiece& piece, const Region& region,
                                 const glm::dvec3& point) {
  SheetBound sheet(region.part_of(piece.net), point);
  if (is_beyond(sheet.least_distance())) return true;
  if (!sheet.has_one_nearest()) return false;
  const auto from_point = [&](const Lowest& lowest) {
    PatchPoint place = piece.at(lowest.u, lowest.v);
    place.position -= point;
    return place;
  };
  const Region wide = region.continued();
  const Lowest beyond = lowest_in(piece, wide, region.start(), point);
  if (!beyond.is_lowest || wide.is_at_border(beyond.u, beyond.v) ||
      !sheet.is_over_convex_part(from_point(beyond).position)) {
    const Lowest lowest = lowest_in(piece, region, region.start(), point);
    take(lowest.value, piece.frame.at(lowest.u, lowest.v));
    return wanted_ < 0 || sheet.least_square(from_point(lowest)) >= wanted_;
  }
  const auto is_in = [](double t) { return t >= 0 && t <= 1; };
  if (is_in(beyond.u) && is_in(beyond.v)) {
    take(beyond.value, piece.frame.at(beyond.u, beyond.v));
    return true;
  }
  for (const bool along_v : {false, true}) {
    for (const bool upper : {false, true}) {
      if ((upper ? region.high : region.low)[along_v] != (upper ? 1 : 0)) continue;
      Region border = region;
      border.fix(along_v, upper);
      search_region(piece, border, point);
    }
  }
  return true;
}

void NearestSearch::take(double square_distance, const glm::dvec2& place) {
  if (!(square_distance < best_.square_distance)) return;
  best_ = {corner_, place.x, place.y, square_distance};
  want();
}

void NearestSearch::want() {
  const double nearer = (1 - kRelative) * std::sqrt(best_.square_distance) - absolute_;
  wanted_ = nearer > 0 ? nearer * nearer : -1;
}

// Boxes and planes are exact but for rounding.
bool NearestSearch::is_near(const PatchBox& box, const glm::dvec3& point) const {
  return square_distance(box, point) <= wanted_ * (1 + 1e-12);
}

// Of bounds that are exact but for rounding.
bool NearestSearch::is_beyond(double distance) const {
  const double least = distance - 1e-15;
  return least > 0 && least * least > wanted_ * (1 + 1e-12);
}

// A piece that is not done with by its bounds or one descent waits until the others have been
// looked at: what is found there by then mostly tells that it has nothing nearer.
void NearestSearch::search_piece(const PatchPiece& piece, const glm::dvec3& point) {
  if (wanted_ < 0 || is_beyond(piece.least_distance(point)) ||
      is_beyond(SheetBound(piece.net, point).least_distance()))
    return;
  ++region_count_;
  const Region region(piece.net, point);
  if (is_far(region)) return;
  if (descend(piece, region, point) && region.net.is_convex()) return;
  if (!is_far(region)) split_later_.push_back({corner_, piece, point});
}

void NearestSearch::search_waiting_pieces() {
  for (const WaitingPiece& waiting : split_later_) {
    corner_ = waiting.corner;
    search_region(waiting.piece, Region(waiting.piece.net, waiting.point), waiting.point);
  }
  split_later_.clear();
}

// Bounds of what lies at the point itself may be below nothing.
bool NearestSearch::is_far(const Region& region) const {
  return wanted_ < 0 || region.least() >= wanted_;
}

// A region has nothing nearer, or is left for its border, or is convex so that a descent ends at
// its nearest place; else its halves are searched, the nearer one first.
void NearestSearch::search_region(const PatchPiece& piece, Region region, const glm::dvec3& point) {
  if (is_far(region)) return;
  if (++region_count_ % kPatience == 0) {
    absolute_ *= 10;
    want();
  }
  if (region.net.largest() < kWorn * region.made_of) {
    region.make_again(piece.net, point);
    if (is_far(region)) return;
  }
  for (const bool along_v : {false, true}) {
    const int slope = region.is_fixed(along_v) ? 0 : region.net.slope(along_v);
    if (slope == 0) continue;
    const bool upper = slope < 0;
    const double end = upper ? region.high[along_v] : region.low[along_v];
    if (end > 0 && end < 1) return;  // the region beyond has it, and nearer places
    region.fix(along_v, upper);
  }
  const bool is_line = region.is_fixed(false) || region.is_fixed(true);
  const bool is_convex = is_line ? (region.is_fixed(false) || region.net.is_convex_along(false)) &&
                                       (region.is_fixed(true) || region.net.is_convex_along(true))
                                 : region.net.is_convex();
  const bool is_nearer = region.net.least_at_corners() < best_.square_distance;
  if ((is_convex || is_nearer) && descend(piece, region, point) && is_convex) return;
  if (is_far(region) || (!is_line && search_sheet(piece, region, point))) return;
  if (!(region.extent[0] + region.extent[1] > kAbsolute)) {  // NaN too
    descend(piece, region, point);
    return;
  }
  // Not along what has no length: needles would be cut without end.
  const bool along_v = region.extent[0] <= 0.5 * kAbsolute ||
                       (region.extent[1] > 0.5 * kAbsolute && region.net.bends_more_along_v());
  Region near = region.half(along_v, false), far = region.half(along_v, true);
  if (far.net.least() < near.net.least()) std::swap(near, far);
  search_region(piece, near, point);
  search_region(piece, far, point);
}

// Quarter by quarter, the nearest one first, those that come near enough. Where a quarter is no
// polynomial, each polynomial of it.
void NearestSearch::search_corner(std::int32_t corner, const glm::dvec3& target) {
  corner_ = corner;
  ++corner_count_;
  PatchPieces& pieces = kept_[static_cast<std::size_t>(corner) % kept_.size()];
  pieces.move_to(corner);
  struct Start {
    double square_distance;
    std::size_t quarter;
  };
  std::array<Start, 4> starts;
  const glm::dvec3 point = target - pieces.own();
  for (std::size_t q = 0; q < 4; ++q) starts[q] = {square_distance(pieces.box(q), point), q};
  std::ranges::sort(starts, {}, [](const Start& start) {
    return std::pair(start.square_distance, start.quarter);
  });
  for (const auto& [_, q] : starts) {
    if (!is_near(pieces.box(q), point)) break;
    if (const PatchPiece* const piece = pieces.piece(q)) {
      search_piece(*piece, point);
    } else {
      const glm::dvec3 off = pieces.vertex(q) - point;
      take(glm::dot(off, off), PatchPieces::vertex_frame(q).at(0, 0));
      for (std::size_t halving = 0; const PatchRing* const ring = pieces.ring(q, halving);
           ++halving) {
        for (std::size_t k = 0; k < ring->pieces.size(); ++k)
          if (is_near(ring->boxes[k], point)) search_piece(ring->pieces[k], point);
        if (!is_near(ring->rest, point)) break;
      }
    }
  }
}

NearestPlace NearestSearch::run(const glm::dvec3& point) {
  best_ = {.corner = -1, .square_distance = std::numeric_limits<double>::infinity()};
  absolute_ = kAbsolute;
  corner_count_ = region_count_ = 0;
  want();
  const auto& nodes = tree_.nodes();
  const glm::dvec3 turned = tree_.turned(point);
  waiting_.assign(1, {0, square_distance(nodes[0].box, turned)});
  while (!waiting_.empty()) {
    const Waiting next = waiting_.back();
    waiting_.pop_back();
    if (next.square_distance >= wanted_) continue;
    const CornerTree::Node& node = nodes[next.node];
    if (node.count > 0) {
      for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
        const auto at = static_cast<std::size_t>(i);
        if (square_distance(tree_.boxes()[at], turned) < wanted_)
          search_corner(tree_.corners()[at], point);
      }
      continue;
    }
    Waiting left{next.node + 1, 0}, right{node.right, 0};
    left.square_distance = square_distance(nodes[left.node].box, turned);
    right.square_distance = square_distance(nodes[right.node].box, turned);
    // The nearer one is looked at first.
    if (left.square_distance < right.square_distance) std::swap(left, right);
    waiting_.push_back(left);
    waiting_.push_back(right);
  }
  search_waiting_pieces();
  return best_;
}

}  // namespace planish
