#include "planish/patches/patch_form.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <utility>

#include "planish/core/assert.h"
#include "planish/patches/patch_rings.h"
#include "planish/patches/quarter_turn.h"

namespace planish {
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
    const auto cosine = [&](std::int32_t j) { return std::cos(2 * std::numbers::pi * j / n); };
    if (form.patch.has_ring_sums) {
      const auto sums = static_cast<std::size_t>(form.patch.ring_sums_column());
      const double even = 1 + cosine(1), odd = std::sin(2 * std::numbers::pi / n);
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

}  // namespace planish
