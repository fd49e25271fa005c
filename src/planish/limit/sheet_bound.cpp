#include "planish/limit/sheet_bound.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "planish/core/unit_vector.h"
#include "planish/limit/patch_box.h"

namespace planish {
namespace {

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

}  // namespace

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

}  // namespace planish
