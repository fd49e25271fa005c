#include "planish/patches/patch_form.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "planish/core/guards.h"
#include "planish/core/portable_math.h"
#include "planish/patches/bezier_net.h"
#include "planish/patches/doo_sabin_step.h"

namespace planish {
namespace {

// Rings of more points go by sums. Below, the products of whole rows take hardly longer, and are
// those that the rule is written in.
constexpr std::size_t kLargeRing = 32;
constexpr std::size_t kMostSums = 3;

void add_dense(std::span<const double> dense, PatchRows& rows) {
  for (std::size_t k = 0; k < dense.size(); ++k) {
    if (dense[k] != 0) rows.add(static_cast<std::int32_t>(k), dense[k]);
  }
  rows.end_row();
}

// X_i = P_i / 4 + sum_j (3 + 2 cos(2 pi (j - i) / n)) P_j / (4 n): with the cosine of the
// difference written out, the sums of P_j, cos_j P_j and sin_j P_j are all that is left of j.
void add_doo_sabin_ring(std::span<const std::int32_t> ring, std::int32_t first_sum,
                        PatchStep& step) {
  const auto n = static_cast<double>(ring.size());
  const auto angle = [n](std::size_t j) {
    return 2 * std::numbers::pi * static_cast<double>(j) / n;
  };
  for (const std::int32_t column : ring) step.sums.add(column, 1);
  step.sums.end_row();
  for (std::size_t j = 0; j < ring.size(); ++j) step.sums.add(ring[j], portable::cos(angle(j)));
  step.sums.end_row();
  for (std::size_t j = 0; j < ring.size(); ++j) step.sums.add(ring[j], portable::sin(angle(j)));
  step.sums.end_row();
  for (std::size_t i = 0; i < ring.size(); ++i) {
    step.rows.add(ring[i], 0.25);
    step.rows.add(first_sum, 0.75 / n);
    step.rows.add(first_sum + 1, 0.5 / n * portable::cos(angle(i)));
    step.rows.add(first_sum + 2, 0.5 / n * portable::sin(angle(i)));
    step.rows.end_row();
  }
}

// X_i = P_i / 2 + (P_i-1 + P_i+1) / 8 + sum_j P_j / (4 n).
void add_averaged_ring(std::span<const std::int32_t> ring, std::int32_t first_sum,
                       PatchStep& step) {
  const std::size_t n = ring.size();
  for (const std::int32_t column : ring) step.sums.add(column, 1);
  step.sums.end_row();
  for (std::size_t i = 0; i < n; ++i) {
    step.rows.add(ring[i], 0.5);
    step.rows.add(ring[(i + n - 1) % n], 0.125);
    step.rows.add(ring[(i + 1) % n], 0.125);
    step.rows.add(first_sum, 0.25 / static_cast<double>(n));
    step.rows.end_row();
  }
}

}  // namespace

void PatchRows::add(std::int32_t column, double weight) {
  columns.push_back(column);
  weights.push_back(weight);
}

void PatchStep::apply(std::span<const glm::dvec3> points, std::vector<glm::dvec3>& result) const {
  result.resize(rows.row_count());
  if (sums.empty()) {
    for (std::size_t k = 0; k < result.size(); ++k)
      result[k] = rows.combine(k, points.data()).value();
    return;
  }
  std::array<glm::dvec3, kMostSums> summed{};
  for (std::size_t s = 0; s < sums.row_count(); ++s)
    summed[s] = sums.combine(s, points.data()).value();
  for (std::size_t k = 0; k < result.size(); ++k) {
    VectorSum sum;
    for (auto i = rows.offsets[k]; i < rows.offsets[k + 1]; ++i) {
      const auto column = static_cast<std::size_t>(rows.columns[i]);
      sum.add(rows.weights[i],
              column < points.size() ? points[column] : summed[column - points.size()]);
    }
    result[k] = sum.value();
  }
}

PatchStep make_step(const PatchRings& rings, int quarter, const FaceWeights& weights,
                    std::int32_t column_count) {
  PatchStep step;
  const auto add_row = [&](std::span<const double> row) { add_dense(row, step.rows); };
  const std::span<const std::int32_t> ring = rings.ring_columns(quarter);
  if (ring.size() <= kLargeRing) {
    rings.visit_ring_points(quarter, weights, add_row);
  } else if (weights.weights() == Weights::DooSabin) {
    add_doo_sabin_ring(ring, column_count, step);
  } else {
    add_averaged_ring(ring, column_count, step);
  }
  PLANISH_ASSERT(step.sums.row_count() <= kMostSums);
  rings.visit_further_points(quarter, weights, add_row);
  return step;
}

std::vector<double> pulled_back(std::span<const double> rows, const PatchRows& map,
                                std::size_t columns) {
  const std::size_t inner = map.row_count(), row_count = rows.size() / inner;
  std::vector<double> result(row_count * columns, 0.0);
  for (std::size_t r = 0; r < row_count; ++r) {
    for (std::size_t k = 0; k < inner; ++k) {
      const double weight = rows[r * inner + k];
      if (weight == 0) continue;
      for (auto i = map.offsets[k]; i < map.offsets[k + 1]; ++i)
        result[r * columns + static_cast<std::size_t>(map.columns[i])] += weight * map.weights[i];
    }
  }
  return result;
}

std::vector<double> pulled_back(std::span<const double> rows, const PatchStep& step,
                                std::size_t columns) {
  if (step.sums.empty()) return pulled_back(rows, step.rows, columns);
  const std::size_t sum_count = step.sums.row_count(), wide = columns + sum_count;
  const std::vector<double> with_sums = pulled_back(rows, step.rows, wide);
  const std::size_t row_count = with_sums.size() / wide;
  std::vector<double> result;
  for (std::size_t r = 0; r < row_count; ++r) {
    const std::span row = std::span(with_sums).subspan(r * wide, wide);
    std::vector<double> whole = pulled_back(row.subspan(columns), step.sums, columns);
    std::transform(whole.begin(), whole.end(), row.begin(), whole.begin(), std::plus());
    result.insert(result.end(), whole.begin(), whole.end());
  }
  return result;
}

namespace {

// Halvings towards V or F until values there stand in: the error of derivatives falls with
// each, and their rounding doubles. Averaged weights have an eigenvalue close to the tangents'.
constexpr int kHalvings = 27;
constexpr int kHalvingsAveraged = 50;

// Quarters' turns, as PatchPoint::turned() takes them.
constexpr std::array<std::array<int, 2>, 4> kTurns{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};

int quarter_of(double u, double v) { return v < 0.5 ? (u < 0.5 ? 0 : 1) : (u < 0.5 ? 3 : 2); }

// The net of a patch that is one polynomial. Across a curve lie its points mirrored at the curve's
// points, whose curve is then the B-spline's own border. Empty for other classes.
PatchRows net_of(const PatchClass& patch) {
  if (patch.face_size != 4) return {};
  const bool smooth = patch.kind == PatchKind::Smooth && patch.ring_size == 4;
  const bool crease = patch.kind == PatchKind::Crease && patch.ring_size == 2;
  const bool corner = patch.kind == PatchKind::Convex && patch.ring_size == 1;
  if (!smooth && !crease && !corner) return {};
  std::array<std::vector<std::pair<std::int32_t, double>>, 9> rows;
  const auto put = [&](std::size_t i, std::size_t j, std::int32_t column, double weight = 1) {
    rows[i + 3 * j].emplace_back(column, weight);
  };
  const auto mirror = [&](std::size_t i, std::size_t j, std::int32_t column, std::int32_t curve) {
    put(i, j, curve, 2);
    put(i, j, column, -1);
  };
  put(1, 1, 0);
  put(2, 1, patch.ring_column(1));
  put(2, 2, patch.ring_column(2));
  put(1, 2, patch.ring_column(3));
  if (patch.is_leading_sharp()) {
    mirror(1, 0, 0, patch.curve_column(0));
    mirror(2, 0, patch.ring_column(1), patch.leading_column());
  } else {
    put(2, 0, patch.leading_column());
  }
  if (patch.is_trailing_sharp()) {
    mirror(0, 1, 0, patch.curve_column(1));
    mirror(0, 2, patch.ring_column(3), patch.trailing_column());
  } else {
    put(0, 2, patch.trailing_column());
  }
  if (smooth) {
    put(0, 1, patch.face_column(1));
    put(0, 0, patch.face_column(2));
    put(1, 0, patch.face_column(3));
  } else if (crease && patch.place == 0) {
    put(0, 1, patch.face_column(1));
    mirror(0, 0, patch.face_column(1), patch.curve_column(1));
  } else if (crease) {
    put(1, 0, patch.face_column(0));
    mirror(0, 0, patch.face_column(0), patch.curve_column(0));
  } else {
    put(0, 0, patch.vertex_column(), 4);
    put(0, 0, patch.curve_column(0), -2);
    put(0, 0, patch.curve_column(1), -2);
    put(0, 0, 0, 1);
  }
  PatchRows net;
  for (const auto& row : rows) {
    for (const auto& [column, weight] : row) net.add(column, weight);
    net.end_row();
  }
  return net;
}

// Value, first and second derivative of the uniform quadratic B-splines at t.
using Basis = std::array<std::array<double, 3>, 3>;
Basis basis_at(double t) {
  return {{{0.5 * (1 - t) * (1 - t), 0.5 + t * (1 - t), 0.5 * t * t},
           {t - 1, 1 - 2 * t, t},
           {1, -2, 1}}};
}

PatchPoint polynomial_point(const PatchForm& form, const glm::dvec3* points, double u, double v) {
  const Basis bu = basis_at(u), bv = basis_at(v);
  VectorSum position, du, dv, duu, duv, dvv;
  for (std::size_t j = 0; j < 3; ++j) {
    VectorSum value, slope, bend;  // of the row, by u
    for (std::size_t i = 0; i < 3; ++i) {
      const VectorSum point = form.net.combine(i + 3 * j, points);
      value.add(bu[0][i], point);
      slope.add(bu[1][i], point);
      bend.add(bu[2][i], point);
    }
    position.add(bv[0][j], value);
    du.add(bv[0][j], slope);
    dv.add(bv[1][j], value);
    duu.add(bv[0][j], bend);
    duv.add(bv[1][j], slope);
    dvv.add(bv[2][j], value);
  }
  PatchPoint result;
  result.position = position.value();
  result.du = du.value();
  result.dv = dv.value();
  result.duu = duu.value();
  result.duv = duv.value();
  result.dvv = dvv.value();
  result.normal = glm::cross(result.du, result.dv);
  return result;
}

glm::dvec3 combine(const double* row, std::span<const glm::dvec3> points) {
  glm::dvec3 sum(0.0);
  for (std::size_t k = 0; k < points.size(); ++k) sum += row[k] * points[k];
  return sum;
}

PatchPoint corner_point(const PatchForm& form, std::span<const glm::dvec3> points) {
  const auto row = [&](std::size_t i) {
    return combine(form.corner.data() + i * points.size(), points);
  };
  PatchPoint result;
  result.position = row(0);
  result.normal = glm::cross(row(1), row(2));
  result.du = row(3);
  result.dv = row(4);
  result.has_second = false;
  return result;
}

// Weights of the net's points in position, du and dv.
std::vector<double> net_rows(double u, double v) {
  const Basis bu = basis_at(u), bv = basis_at(v);
  std::vector<double> rows;
  for (const auto& [du, dv] : {std::pair{0, 0}, std::pair{1, 0}, std::pair{0, 1}}) {
    for (std::size_t j = 0; j < 3; ++j) {
      for (std::size_t i = 0; i < 3; ++i) rows.push_back(bu[du][i] * bv[dv][j]);
    }
  }
  return rows;
}

// Rows of du and dv by a quarter's parameters, by those of the patch around it.
void turn_rows(std::vector<double>& rows, std::size_t count, int c, int s) {
  for (std::size_t k = 0; k < count; ++k) {
    const double du = rows[count + k], dv = rows[2 * count + k];
    rows[count + k] = 2 * (c * du - s * dv);
    rows[2 * count + k] = 2 * (s * du + c * dv);
  }
}

std::vector<double> weights_down(const PatchForm& form, double u, double v, int halvings) {
  const auto count = static_cast<std::size_t>(form.column_count);
  if (form.is_polynomial()) return pulled_back(net_rows(u, v), form.net, count);
  if ((u == 0 && v == 0 && form.is_singular_at_vertex()) || halvings == 0) {
    std::vector<double> rows(form.corner.begin(),
                             form.corner.begin() + static_cast<std::ptrdiff_t>(count));
    rows.insert(rows.end(), form.corner.begin() + static_cast<std::ptrdiff_t>(3 * count),
                form.corner.end());
    return rows;
  }
  const int quarter = quarter_of(u, v);
  const auto [qu, qv] = seen_from(quarter, 2.0, 2 * u, 2 * v);
  std::vector<double> rows = pulled_back(
      weights_down(*form.quarters[quarter], qu, qv, halvings - 1), form.steps[quarter], count);
  turn_rows(rows, count, kTurns[quarter][0], kTurns[quarter][1]);
  return rows;
}

}  // namespace

PatchPoint PatchPoint::turned(int c, int s, double factor) const {
  PatchPoint result = *this;
  const double square = factor * factor;
  const double cc = c * c, cs = c * s, ss = s * s;
  result.du = factor * (double(c) * du - double(s) * dv);
  result.dv = factor * (double(s) * du + double(c) * dv);
  result.normal = square * normal;
  result.duu = square * (cc * duu - 2 * cs * duv + ss * dvv);
  result.duv = square * (cs * duu + (cc - ss) * duv - cs * dvv);
  result.dvv = square * (ss * duu + 2 * cs * duv + cc * dvv);
  return result;
}

const PatchForm& PatchForms::of(const PatchClass& patch) {
  const auto found = forms_.find(patch);
  if (found != forms_.end()) return *found->second;
  auto made = std::make_unique<PatchForm>();
  PatchForm& form = *made;
  forms_[patch] = std::move(made);  // a quarter may be of the same class
  form.patch = patch;
  form.column_count = patch.column_count();
  largest_count_ = std::max(largest_count_, form.column_count);
  form.halvings = weights_.weights() == Weights::DooSabin ? kHalvings : kHalvingsAveraged;
  form.net = net_of(patch);
  if (form.is_polynomial()) return form;
  const PatchRings rings(patch);
  for (int q = 0; q < 4; ++q) {
    form.steps[q] = make_step(rings, q, weights_, patch.column_count());
    form.quarters[q] = &of(rings.quarter_class(q));
  }
  make_corner(form);
  return form;
}

// Closed forms for smooth vertices and centres with Doo and Sabin's weights: the first Fourier pair
// of the ring, at the directions of the two edges. Elsewhere the derivatives that far halvings
// have.
void PatchForms::make_corner(PatchForm& form) const {
  const auto count = static_cast<std::size_t>(form.column_count);
  form.corner = PatchRings(form.patch).limit(0);
  form.corner.resize(5 * count, 0.0);
  const bool closed_form = weights_.weights() == Weights::DooSabin || form.patch.ring_size == 4;
  if (form.patch.kind == PatchKind::Smooth && closed_form) {
    const std::int32_t n = form.patch.ring_size;
    const auto cosine = [&](std::int32_t j) { return portable::cos(2 * std::numbers::pi * j / n); };
    if (form.patch.has_ring_sums) {
      const auto sums = static_cast<std::size_t>(form.patch.ring_sums_column());
      const double even = 1 + cosine(1), odd = portable::sin(2 * std::numbers::pi / n);
      for (const std::size_t row : {std::size_t{3}, std::size_t{4}}) {
        double* const weights = form.corner.data() + row * count + sums;
        weights[1] = even;
        weights[2] = row == 3 ? -odd : odd;
        weights[0] = -(weights[1] + weights[2]);
      }
      return;
    }
    for (std::int32_t j = 0; j < n; ++j) {
      const auto column = static_cast<std::size_t>(form.patch.face_column(j));
      form.corner[3 * count + column] = 2.0 / n * (cosine(j) + cosine(j + 1));
      form.corner[4 * count + column] = 2.0 / n * (cosine(j) + cosine(j - 1));
    }
    return;
  }
  const double near = std::ldexp(1.0, -20);
  const std::vector<double> along_u = weights_down(form, near, 0, form.halvings);
  const std::vector<double> along_v = weights_down(form, 0, near, form.halvings);
  for (std::size_t k = 0; k < count; ++k) {
    form.corner[3 * count + k] = along_u[count + k];
    form.corner[4 * count + k] = along_v[2 * count + k];
  }
}

void quarter_points(const PatchForm& form, int quarter, std::span<const glm::dvec3> points,
                    std::vector<glm::dvec3>& result) {
  form.steps[quarter].apply(points, result);
}

PatchPoint patch_point(const PatchForm& form, std::span<const glm::dvec3> points, PatchParameter at,
                       PatchScratch& scratch) {
  PLANISH_ASSERT(points.size() == static_cast<std::size_t>(form.column_count));
  const PatchForm* inner = &form;
  std::span<const glm::dvec3> current = points;
  int c = 1, s = 0;
  double factor = 1;
  for (int depth = 0; !inner->is_polynomial(); ++depth) {
    const bool is_singular = at.u == 0 && at.v == 0 && inner->is_singular_at_vertex();
    if (is_singular || depth >= inner->halvings) break;
    const int quarter = quarter_of(at.towards_u, at.towards_v);
    const auto [u, v] = seen_from(quarter, 2.0, 2 * at.u, 2 * at.v);
    const auto [towards_u, towards_v] = seen_from(quarter, 2.0, 2 * at.towards_u, 2 * at.towards_v);
    at = {u, v, towards_u, towards_v};
    quarter_points(*inner, quarter, current, scratch.next);
    inner = inner->quarters[quarter];
    std::swap(scratch.points, scratch.next);
    current = scratch.points;
    const auto [turn_c, turn_s] = kTurns[quarter];
    const int outer_c = c;
    c = turn_c * c - turn_s * s;
    s = turn_s * outer_c + turn_c * s;
    factor *= 2;
  }
  const PatchPoint point = inner->is_polynomial()
                               ? polynomial_point(*inner, current.data(), at.u, at.v)
                               : corner_point(*inner, current);
  return point.turned(c, s, factor);
}

std::vector<double> patch_weights(const PatchForm& form, double u, double v) {
  return weights_down(form, u, v, form.halvings);
}

namespace {

// Sine between du and dv below which they count as parallel, as for normals.
constexpr double kParallel = 1e-6;

}  // namespace

PointCurvature curvature_of(const PatchPoint& point) {
  PointCurvature result;
  if (!point.has_second) return result;
  const glm::dvec3 cross = glm::cross(point.du, point.dv);
  const double area = glm::length(cross);
  const double length_u = glm::length(point.du), length_v = glm::length(point.dv);
  if (!(area > kParallel * length_u * length_v)) return result;
  const glm::dvec3 normal = cross / area;
  // The second form in the orthonormal frame (along, across) of the tangent plane.
  const glm::dvec3 along = point.du / length_u, across = glm::cross(normal, along);
  const double a = 1 / length_u, d = 1 / glm::dot(point.dv, across);
  const double b = -glm::dot(point.dv, along) * a * d;  // across = b du + d dv
  const double uu = -glm::dot(point.duu, normal), uv = -glm::dot(point.duv, normal);
  const double vv = -glm::dot(point.dvv, normal);
  const double xx = a * a * uu, xy = a * (b * uu + d * uv),
               yy = b * b * uu + 2 * b * d * uv + d * d * vv;
  result.mean = 0.5 * (xx + yy);
  result.gaussian = xx * yy - xy * xy;
  const double half = 0.5 * (xx - yy), root = portable::hypot(half, xy);
  result.largest = result.mean + root;
  result.smallest = result.mean - root;
  const double turn = 0.5 * portable::atan2(xy, half);
  result.largest_direction = portable::cos(turn) * along + portable::sin(turn) * across;
  result.smallest_direction = glm::cross(normal, result.largest_direction);
  result.is_known = true;
  return result;
}

namespace {

// De Casteljau's halves of three points that are `step` apart.
void halve(BezierNet& net, std::size_t first, std::size_t step, bool upper) {
  const glm::dvec3 a = net[first], b = net[first + step], c = net[first + 2 * step];
  const glm::dvec3 ab = 0.5 * (a + b), bc = 0.5 * (b + c), middle = 0.5 * (ab + bc);
  net[first] = upper ? middle : a;
  net[first + step] = upper ? bc : ab;
  net[first + 2 * step] = upper ? c : middle;
}

}  // namespace

BezierNet bezier_net(const PatchForm& form, std::span<const glm::dvec3> points) {
  BezierNet net;
  for (std::size_t i = 0; i < 9; ++i) net[i] = form.net.combine(i, points.data()).value();
  // B-spline to Bezier along u, then along v: midpoints at the ends.
  const auto convert = [&](std::size_t first, std::size_t step) {
    const glm::dvec3 middle = net[first + step];
    net[first] = 0.5 * (net[first] + middle);
    net[first + 2 * step] = 0.5 * (middle + net[first + 2 * step]);
  };
  for (std::size_t i = 0; i < 3; ++i) convert(3 * i, 1);
  for (std::size_t i = 0; i < 3; ++i) convert(i, 3);
  return net;
}

BezierNet net_quarter(BezierNet net, bool upper_u, bool upper_v) {
  for (std::size_t i = 0; i < 3; ++i) halve(net, 3 * i, 1, upper_u);
  for (std::size_t i = 0; i < 3; ++i) halve(net, i, 3, upper_v);
  return net;
}

BezierNet turned_net(const BezierNet& net, int turns) {
  BezierNet result;
  for (std::size_t j = 0; j < 3; ++j) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [u, v] = seen_from(turns, std::size_t{2}, i, j);
      result[i + 3 * j] = net[u + 3 * v];
    }
  }
  return result;
}

// By blossoms.
BezierNet net_between(const BezierNet& net, bool along_v, double from, double to) {
  BezierNet result;
  const std::size_t step = along_v ? 3 : 1, across = along_v ? 1 : 3;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t at = k * across;
    const glm::dvec3 &a = net[at], &b = net[at + step], &c = net[at + 2 * step];
    result[at] = quadratic_blossom(a, b, c, from, from);
    result[at + step] = quadratic_blossom(a, b, c, from, to);
    result[at + 2 * step] = quadratic_blossom(a, b, c, to, to);
  }
  return result;
}

namespace {

constexpr int kSamples = 16;      // along a patch, for the largest sum of weights
constexpr double kMargin = 1.02;  // between samples, where there are negative weights

// Around a patch that is one polynomial, or one that is left whole.
PatchBox box_of_form(const PatchForm& form, std::span<const glm::dvec3> points,
                     const PatchReaches& reaches) {
  return form.is_polynomial() ? box_of(bezier_net(form, points))
                              : box_around(points, reaches.of(form));
}

}  // namespace

void PatchBox::add(const glm::dvec3& point) {
  for (int d = 0; d < 3; ++d) {
    low[d] = std::min(low[d], point[d]);
    high[d] = std::max(high[d], point[d]);
  }
}

PatchBox box_of(std::span<const glm::dvec3> points) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  PatchBox box{glm::dvec3(kFar), glm::dvec3(-kFar)};
  for (const glm::dvec3& p : points) box.add(p);
  return box;
}

PatchBox box_around(std::span<const glm::dvec3> points, double reach) {
  const PatchBox box = box_of(points);
  const glm::dvec3 middle = 0.5 * (box.low + box.high), half = 0.5 * reach * (box.high - box.low);
  return {middle - half, middle + half};
}

double patch_reach(const PatchForm& form) {
  const auto count = static_cast<std::size_t>(form.column_count);
  double most = 1;
  for (int b = 0; b <= kSamples; ++b) {
    for (int a = 0; a <= kSamples; ++a) {
      const std::vector<double> rows =
          patch_weights(form, double(a) / kSamples, double(b) / kSamples);
      double sum = 0;
      for (std::size_t k = 0; k < count; ++k) sum += std::abs(rows[k]);
      most = std::max(most, sum);
    }
  }
  return most > 1 + 1e-9 ? kMargin * most : 1 + 1e-12;
}

void PatchReaches::add(const PatchForm& form) {
  if (form.is_polynomial() || reaches_.contains(&form)) return;
  reaches_[&form] = patch_reach(form);
  for (const PatchForm* quarter : form.quarters) add(*quarter);
}

std::array<PatchBox, 4> quarter_boxes(const PatchForm& form, std::span<const glm::dvec3> points,
                                      const PatchReaches& reaches,
                                      std::vector<glm::dvec3>& scratch) {
  std::array<PatchBox, 4> boxes;
  if (form.is_polynomial()) {
    const BezierNet whole = bezier_net(form, points);
    for (int q = 0; q < 4; ++q) boxes[q] = box_of(net_quarter(whole, q == 1 || q == 2, q >= 2));
    return boxes;
  }
  for (int q = 0; q < 4; ++q) {
    quarter_points(form, q, points, scratch);
    boxes[q] = box_of_form(*form.quarters[q], scratch, reaches);
  }
  return boxes;
}

PatchBox patch_box(const PatchForm& form, std::span<const glm::dvec3> points,
                   const PatchReaches& reaches) {
  if (form.is_polynomial()) return box_of_form(form, points, reaches);
  std::vector<glm::dvec3> scratch;
  PatchBox box = box_of({});
  for (const PatchBox& quarter : quarter_boxes(form, points, reaches, scratch)) {
    box.add(quarter.low);
    box.add(quarter.high);
  }
  return box;
}

}  // namespace planish
