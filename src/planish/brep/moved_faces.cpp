#include "planish/brep/moved_faces.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <utility>

#include "planish/analytic/spline_point.h"

namespace planish {
namespace {

constexpr std::size_t kQuadratic = 2;

void sort_knots(std::vector<double>& knots) {
  std::ranges::sort(knots);
  const auto rest = std::ranges::unique(knots);
  knots.erase(rest.begin(), rest.end());
}

// Adds those of `others` that lie between the first and the last one.
void add_knots(std::span<const double> others, std::vector<double>& knots) {
  const double first = knots.front(), last = knots.back();
  for (const double t : others)
    if (t > first && t < last) knots.push_back(t);
  sort_knots(knots);
}

// Knots and the middles between them: where values tell a spline.
std::vector<double> with_middles(std::span<const double> knots) {
  std::vector<double> places{knots.front()};
  for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
    places.push_back(0.5 * (knots[i] + knots[i + 1]));
    places.push_back(knots[i + 1]);
  }
  return places;
}

// The blossom of a quadratic polynomial at both ends of a span, by its values there and halfway.
template <class Value>
Value blossom(const Value& first, const Value& middle, const Value& last) {
  return 2.0 * middle - 0.5 * (first + last);
}

// Control points by values at with_middles(knots).
template <class Value>
std::vector<Value> points_through(std::span<const Value> values) {
  std::vector<Value> points{values.front()};
  for (std::size_t i = 0; i + 2 < values.size(); i += 2)
    points.push_back(blossom(values[i], values[i + 1], values[i + 2]));
  points.push_back(values.back());
  return points;
}

}  // namespace

glm::dvec3 QuadraticCurve::at(double t) const {
  return spline_point<kQuadratic>(
      kQuadratic, knots, [&](std::size_t i) { return points[i]; }, t);
}

QuadraticCurve QuadraticCurve::part(double from, double to) const {
  const double low = std::min(from, to), high = std::max(from, to);
  QuadraticCurve result{.knots = {low, high}};
  add_knots(knots, result.knots);
  if (from > to) std::ranges::reverse(result.knots);
  for (double& t : result.knots) t = std::abs(t - from);
  const double sign = from > to ? -1 : 1;
  result.points = quadratic_points(result.knots, [&](double t) { return at(from + sign * t); });
  return result;
}

std::vector<glm::dvec3> quadratic_points(std::span<const double> knots,
                                         const std::function<glm::dvec3(double)>& at) {
  std::vector<glm::dvec3> values;
  for (const double t : with_middles(knots)) values.push_back(at(t));
  return points_through(std::span<const glm::dvec3>(values));
}

std::optional<QuadraticCurve> curve_near(std::vector<double> knots,
                                         const std::function<glm::dvec3(double)>& target,
                                         double tolerance) {
  constexpr std::size_t kMostSpans = 4096;
  constexpr int kMostRounds = 24;
  QuadraticCurve curve{.knots = std::move(knots)};
  for (int round = 0; round <= kMostRounds && curve.knots.size() <= kMostSpans; ++round) {
    curve.points = quadratic_points(curve.knots, target);
    std::vector<double> halves;
    for (std::size_t i = 0; i + 1 < curve.knots.size(); ++i) {
      const double from = curve.knots[i], step = curve.knots[i + 1] - from;
      for (const double part : {0.0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875}) {
        const double t = from + part * step;
        if (glm::length(curve.at(t) - target(t)) <= tolerance) continue;
        halves.push_back(from + 0.5 * step);
        break;
      }
    }
    if (halves.empty()) return curve;
    add_knots(halves, curve.knots);
  }
  return std::nullopt;
}

double fading(double t) {
  t = std::abs(t);
  return t < 0.5 ? 1 - 2 * t * t : t < 1 ? 2 * (1 - t) * (1 - t) : 0;
}

void add_fading_knots(double at, std::vector<double>& knots) {
  const std::array<double, 4> own{at - 1, at - 0.5, at + 0.5, at + 1};
  add_knots(own, knots);
}

void move_sides(const Brep& brep, const std::array<MovedSide, 4>& sides, Brep::Face& face) {
  std::array<std::vector<double>, 2> knots{face.knots_u, face.knots_v};
  const glm::dvec2 end(knots[0].back(), knots[1].back());
  for (int s = 0; s < 4; ++s) {
    if (sides[s].knots.empty()) continue;
    add_knots(sides[s].knots, knots[s % 2]);
    const std::array<double, 4> across{0, end.x, end.y, 0};
    add_fading_knots(across[s], knots[1 - s % 2]);
  }
  // Of a place beside a side: along it, and how far in.
  const auto along = [](int s, const glm::dvec2& at) { return s % 2 == 0 ? at.x : at.y; };
  const auto inside = [&](int s, const glm::dvec2& at) {
    return s == 0 ? at.y : s == 1 ? end.x - at.x : s == 2 ? end.y - at.y : at.x;
  };
  const std::array<glm::dvec2, 4> corners{
      {{0, 0}, {end.x, 0}, end, {0, end.y}}};  // where each side begins
  std::array<glm::dvec3, 4> corner_shifts{};
  for (int s = 0; s < 4; ++s)
    for (const int side : {s, (s + 3) % 4})
      if (sides[side].shift) corner_shifts[s] = sides[side].shift(along(side, corners[s]));
  const auto shift = [&](const glm::dvec2& at) {
    glm::dvec3 sum(0.0);
    for (int s = 0; s < 4; ++s) {
      const double part = fading(inside(s, at));
      if (part == 0) continue;
      if (sides[s].shift) sum += part * sides[s].shift(along(s, at));
      // Both sides at a corner move what is beside it.
      const int before = (s + 3) % 4;
      if (sides[s].shift && sides[before].shift)
        sum -= part * fading(inside(before, at)) * corner_shifts[s];
    }
    return sum;
  };
  const std::vector<double> us = with_middles(knots[0]), vs = with_middles(knots[1]);
  std::vector<std::vector<glm::dvec3>> rows;  // control points along u, by place along v
  for (const double v : vs) {
    std::vector<glm::dvec3> values;
    for (const double u : us)
      values.push_back(point_of(brep, face, {u, v}) + shift(glm::dvec2(u, v)));
    rows.push_back(points_through(std::span<const glm::dvec3>(values)));
  }
  const std::size_t width = rows.front().size(), height = point_count(kQuadratic, knots[1]);
  std::vector<glm::dvec3> points(width * height);
  for (std::size_t i = 0; i < width; ++i) {
    std::vector<glm::dvec3> values;
    for (const auto& row : rows) values.push_back(row[i]);
    const std::vector<glm::dvec3> column = points_through(std::span<const glm::dvec3>(values));
    for (std::size_t j = 0; j < height; ++j) points[i + width * j] = column[j];
  }
  face.knots_u = std::move(knots[0]);
  face.knots_v = std::move(knots[1]);
  face.points = std::move(points);
  face.plane.reset();
}

}  // namespace planish
