// Based on: Farouki and Rajan, "Algorithms for polynomials in Bernstein form", 1988.
#include "planish/brep/caps.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <span>

#include "planish/brep/brep.h"
#include "planish/core/portable_math.h"
#include "planish/core/vectors.h"
#include "planish/mesh/face_geometry.h"

namespace planish {
namespace {

// Coordinates in files are rounded by so much, of the diagonal (see step_decimals()).
constexpr double kRounding = 2e-13;
// Parts of a border that are looked at first, and how often one is halved where normals vanish.
constexpr int kParts = 8, kMostHalvings = 24, kCoarseHalvings = 3;
// Bounds are made tighter that are larger than this many times what is seen, and than this.
constexpr double kMostLoose = 1.1, kSmallestJump = 1e-6;

constexpr std::size_t kMostProduct = 4 * kMostSplineDegree - 2;
constexpr auto kBinomials = [] {
  std::array<std::array<double, kMostProduct + 1>, kMostProduct + 1> rows{};
  for (std::size_t n = 0; n <= kMostProduct; ++n) {
    rows[n][0] = 1;
    for (std::size_t k = 1; k <= n; ++k)
      rows[n][k] = rows[n - 1][k - 1] + (k < n ? rows[n - 1][k] : 0);
  }
  return rows;
}();

// What Bezier points i and j of polynomials of degrees m and n count in point i + j of the product.
double share(std::size_t m, std::size_t i, std::size_t n, std::size_t j) {
  return kBinomials[m][i] * kBinomials[n][j] / kBinomials[m + n][i + j];
}
// The same of the products with normals, by i and j: quotients take time.
template <std::size_t kDegree>
constexpr auto kNormalShares = [] {
  constexpr std::size_t kNormal = 2 * kDegree - 1;
  std::array<std::array<double, kNormal + 1>, kDegree + 1> shares{};
  for (std::size_t i = 0; i <= kDegree; ++i)
    for (std::size_t j = 0; j <= kNormal; ++j)
      shares[i][j] =
          kBinomials[kDegree][i] * kBinomials[kNormal][j] / kBinomials[kDegree + kNormal][i + j];
  return shares;
}();

// Adds the products of the values of normals' Bezier points with `of(k)` of a polynomial of the
// degree, over a square.
template <std::size_t kDegree, class Normal, class Of>
void add_products(std::span<const Normal> normals, const Of& of, std::span<double> products) {
  constexpr std::size_t kRow = kDegree + 1, kNormalRow = 2 * kDegree, kProductRow = 3 * kDegree;
  const auto& shares = kNormalShares<kDegree>;
  for (std::size_t y = 0; y < kNormalRow; ++y)
    for (std::size_t x = 0; x < kNormalRow; ++x)
      for (std::size_t j = 0; j < kRow; ++j)
        for (std::size_t i = 0; i < kRow; ++i)
          products[x + i + kProductRow * (y + j)] +=
              shares[j][y] * shares[i][x] * of(i + kRow * j, normals[x + kNormalRow * y]);
}
template <class Normal, class Of>
void add_products(std::size_t degree, std::span<const Normal> normals, const Of& of,
                  std::span<double> products) {
  if (degree == 2) return add_products<2>(normals, of, products);
  add_products<3>(normals, of, products);
}

// Bezier points of a polynomial in one variable.
template <class Value>
struct Curve {
  std::size_t degree = 0;
  std::array<Value, kMostProduct + 1> points{};

  [[nodiscard]] std::span<const Value> all() const { return std::span(points).first(degree + 1); }
};

template <class A, class B, class Product>
auto product(const Curve<A>& a, const Curve<B>& b, const Product& of) {
  Curve<decltype(of(a.points[0], b.points[0]))> result;
  result.degree = a.degree + b.degree;
  for (std::size_t i = 0; i <= a.degree; ++i)
    for (std::size_t j = 0; j <= b.degree; ++j)
      result.points[i + j] += share(a.degree, i, b.degree, j) * of(a.points[i], b.points[j]);
  return result;
}

Curve<glm::dvec3> part_of(std::span<const glm::dvec3> points, double from, double to) {
  Curve<glm::dvec3> part;
  part.degree = points.size() - 1;
  for (std::size_t k = 0; k <= part.degree; ++k)
    part.points[k] =
        bezier_blossom(points.data(), part.degree, bezier_arguments(part.degree, k, from, to));
  return part;
}

double longest(std::span<const glm::dvec3> vectors) {
  double length = 0;
  for (const glm::dvec3& v : vectors) length = std::max(length, glm::length(v));
  return length;
}

// No vector of the curve is shorter; 0 where they turn by too much to tell.
double shortest(std::span<const glm::dvec3> vectors) {
  glm::dvec3 sum(0.0);
  for (const glm::dvec3& v : vectors) sum += v;
  const glm::dvec3 axis = unit_or_zero(sum);
  double least = std::numeric_limits<double>::max();
  for (const glm::dvec3& v : vectors) least = std::min(least, glm::dot(v, axis));
  return std::max(least, 0.0);
}

// The larger principal curvature at a corner of a piece, without limit where no normal is.
double corner_curvature(const SquarePiece& piece, bool at_end, bool at_top) {
  const std::size_t p = piece.degree, row = p + 1;
  const auto at = [&](std::size_t i, std::size_t j) {
    return piece.net[(at_end ? p - i : i) + row * (at_top ? p - j : j)];
  };
  const auto degree = static_cast<double>(p);
  const glm::dvec3 u = degree * (at(1, 0) - at(0, 0)), v = degree * (at(0, 1) - at(0, 0));
  const glm::dvec3 across = glm::cross(u, v);
  const double area = glm::length(across);
  if (!(area > 0)) return std::numeric_limits<double>::infinity();
  const auto second = [&](const glm::dvec3& difference, double factor) {
    return factor * glm::dot(difference, across) / area;
  };
  const double uu = second(at(2, 0) - 2.0 * at(1, 0) + at(0, 0), degree * (degree - 1)),
               vv = second(at(0, 2) - 2.0 * at(0, 1) + at(0, 0), degree * (degree - 1)),
               uv = second(at(1, 1) - at(1, 0) - at(0, 1) + at(0, 0), degree * degree);
  const double e = glm::dot(u, u), f = glm::dot(u, v), g = glm::dot(v, v);
  const double mean = (e * vv - 2 * f * uv + g * uu) / (2 * area * area);
  const double gaussian = (uu * vv - uv * uv) / (area * area);
  return std::abs(mean) + std::sqrt(std::max(0.0, mean * mean - gaussian));
}

// A border's part by part: those away from the vertex first, since what is known by then need not
// be looked at once more.
class JumpSearch {
 public:
  JumpSearch(const MeetingSides& sides, const glm::dvec3& vertex, Jump& largest)
      : sides_(sides), vertex_(vertex), largest_(largest) {
    for (std::size_t k = 0; k < sides.degree; ++k) along_[k] = sides.line[k + 1] - sides.line[k];
  }

  void look(double from, double to, int halvings) {
    const Curve<glm::dvec3> line = part_of(points_of(sides_.line), from, to);
    const auto is_near = [&](const glm::dvec3& p) {
      return glm::length(p - vertex_) <= Brep::kSamePlace;
    };
    if (std::ranges::all_of(line.all(), is_near)) return;
    const Curve<glm::dvec3> along = part_of(std::span(along_).first(sides_.degree), from, to),
                            left = part_of(points_of(sides_.left), from, to),
                            right = part_of(points_of(sides_.right), from, to);
    const auto cross = [](const glm::dvec3& a, const glm::dvec3& b) { return glm::cross(a, b); };
    const auto dot = [](const glm::dvec3& a, const glm::dvec3& b) { return glm::dot(a, b); };
    const Curve<glm::dvec3> left_normal = product(left, along, cross),
                            right_normal = product(along, right, cross);
    const double rounding =
        turned_by_rounding(longest(along.all()), longest(left.all()), shortest(left_normal.all())) +
        turned_by_rounding(longest(along.all()), longest(right.all()),
                           shortest(right_normal.all()));
    const bool is_clear = rounding < 0.5 * std::numbers::pi;
    // A part of which neither end has a normal has none, as far as that can be told.
    const auto has_normal = [&](const Curve<glm::dvec3>& side, const Curve<glm::dvec3>& normal,
                                bool at_end) {
      const auto length = [&](const Curve<glm::dvec3>& of) {
        return glm::length(of.points[at_end ? of.degree : 0]);
      };
      return turned_by_rounding(length(along), length(side), length(normal)) <
             0.25 * std::numbers::pi;
    };
    const auto has_normals = [&](bool at_end) {
      return has_normal(left, left_normal, at_end) && has_normal(right, right_normal, at_end);
    };
    double angle = 0.5 * std::numbers::pi;
    bool is_bounded = false;
    if (is_clear) {
      // The cross product of the normals is along det(along, left, right).
      const Curve<double> determinant = product(left_normal, right, dot);
      Curve<double> one;
      one.degree = sides_.degree - 1;
      one.points.fill(1);
      const auto times = [](double a, double b) { return a * b; };
      const Curve<double> across = product(determinant, one, times),
                          with = product(left_normal, right_normal, dot);
      double tangent = 0;
      is_bounded = true;
      for (std::size_t k = 0; k <= with.degree; ++k) {
        is_bounded = is_bounded && with.points[k] > 0;
        tangent = std::max(tangent, std::abs(across.points[k]) / with.points[k]);
      }
      if (is_bounded) angle = portable::atan(tangent * longest(along.all()));
    }
    const glm::dvec3 middle =
        bezier_blossom(sides_.line.data(), sides_.degree, same_arguments(0.5 * (from + to)));
    if (is_bounded && angle - rounding <= largest_.angle) return;
    // At its ends, where Bezier points are values.
    double seen = 0;
    if (is_clear)
      for (const std::size_t k : {std::size_t{0}, left_normal.degree})
        seen = std::max(seen, angle_between(left_normal.points[k], right_normal.points[k]));
    const bool is_loose = angle > kMostLoose * seen + kSmallestJump;
    const bool is_split =
        !is_bounded
            ? halvings < (is_clear || !(has_normals(false) || has_normals(true)) ? kCoarseHalvings
                                                                                 : kMostHalvings)
            : (is_loose || is_near(line.points[0])) && halvings < kMostHalvings;
    if (is_split) {
      look(0.5 * (from + to), to, halvings + 1);
      look(from, 0.5 * (from + to), halvings + 1);
    } else if (is_bounded) {
      largest_.add(angle - rounding, middle);
    } else if (is_clear) {
      largest_.add(seen - rounding, middle);  // above a right angle somewhere
    }
  }

 private:
  [[nodiscard]] std::span<const glm::dvec3> points_of(
      const std::array<glm::dvec3, kMostSplineDegree + 1>& points) const {
    return std::span(points).first(sides_.degree + 1);
  }

  const MeetingSides& sides_;
  const glm::dvec3& vertex_;
  Jump& largest_;
  std::array<glm::dvec3, kMostSplineDegree> along_{};
};

}  // namespace

double turned_by_rounding(double along, double across, double product) {
  return product > 0 ? kRounding * (along + across) / product
                     : std::numeric_limits<double>::infinity();
}

void add_jump(const MeetingSides& sides, const glm::dvec3& vertex, Jump& largest) {
  JumpSearch search(sides, vertex, largest);
  for (int k = kParts - 1; k >= 0; --k)
    search.look(static_cast<double>(k) / kParts, static_cast<double>(k + 1) / kParts, 0);
}

PieceBound::PieceBound(const SquarePiece& piece) : degree_(piece.degree) {
  const std::size_t p = degree_, row = p + 1, normal_row = 2 * p;
  const auto at = [&](std::size_t i, std::size_t j) { return piece.net[i + row * j]; };
  PointNet along_u{}, along_v{};
  for (std::size_t j = 0; j <= p; ++j) {
    for (std::size_t i = 0; i <= p; ++i) {
      if (i < p) along_u[i + row * j] = at(i + 1, j) - at(i, j);
      if (j < p) along_v[i + row * j] = at(i, j + 1) - at(i, j);
    }
  }
  for (const bool at_end : {false, true})
    for (const bool at_top : {false, true})
      curvature_ = std::max(curvature_, corner_curvature(piece, at_end, at_top));
  for (std::size_t j = 0; j <= p; ++j) {
    for (std::size_t i = 0; i < p; ++i) {
      for (std::size_t y = 0; y < p; ++y) {
        const double share_v = share(p, j, p - 1, y);
        for (std::size_t x = 0; x <= p; ++x)
          normals_[i + x + normal_row * (j + y)] +=
              share(p - 1, i, p, x) * share_v *
              glm::cross(along_u[i + row * j], along_v[x + row * y]);
      }
    }
  }
  glm::dvec3 sum(0.0);
  const auto normals = std::span(normals_).first(normal_row * normal_row);
  for (const glm::dvec3& normal : normals) sum += normal;
  axis_ = unit_or_zero(sum);
  least_ = std::numeric_limits<double>::max();
  for (const glm::dvec3& normal : normals) least_ = std::min(least_, glm::dot(normal, axis_));
  add_products(
      p, std::span<const glm::dvec3>(normals_),
      [&](std::size_t, const glm::dvec3& normal) { return glm::dot(normal, axis_); }, along_);
  double low = std::numeric_limits<double>::max(), high = -low;
  for (std::size_t k = 0; k < row * row; ++k) {
    low = std::min(low, glm::dot(piece.net[k], axis_));
    high = std::max(high, glm::dot(piece.net[k], axis_));
  }
  thickness_ = high - low;
}

double PieceBound::along_normals(const PointNet& apart) const {
  std::array<double, kMostProducts> off{};
  add_products(
      degree_, std::span<const glm::dvec3>(normals_),
      [&](std::size_t k, const glm::dvec3& normal) { return glm::dot(apart[k], normal); }, off);
  double largest = 0;
  for (std::size_t k = 0; k < 9 * degree_ * degree_; ++k)
    largest = std::max(largest, std::abs(off[k]) / along_[k]);
  return largest;
}

// Along normals, and what the surface bends away by from its tangent planes on the way to what is
// below the other; where normals turn too much for that, by what the piece leaves a plane.
double PieceBound::distance(const PointNet& apart, double known) const {
  const auto points = std::span(apart).first((degree_ + 1) * (degree_ + 1));
  const double farthest = longest(points);
  if (farthest <= known) return known;
  double off_plane = 0;
  for (const glm::dvec3& by : points)
    off_plane = std::max(off_plane, std::abs(glm::dot(by, axis_)));
  double bound = axis_ == glm::dvec3(0.0) ? farthest : std::min(farthest, off_plane + thickness_);
  const double bent = 0.5 * curvature_ * farthest * farthest;
  if (least_ > 0 && bent < bound && known < bound)
    bound = std::min(bound, along_normals(apart) + bent);
  return std::max(bound, known);
}

}  // namespace planish
