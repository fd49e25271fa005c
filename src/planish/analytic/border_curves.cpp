#include "planish/analytic/border_curves.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <numbers>

#include "planish/analytic/spline_point.h"
#include "planish/core/portable_math.h"

namespace planish {
namespace {

bool has_axis(const AnalyticSurface& surface) {
  return surface.kind != AnalyticKind::Plane && surface.kind != AnalyticKind::Sphere;
}

BorderCurve circle_through(const glm::dvec3& centre, const glm::dvec3& axis, const glm::dvec3& p) {
  const glm::dvec3 from = p - centre, flat = from - glm::dot(from, axis) * axis;
  const double radius = glm::length(flat);
  return {.kind = CurveKind::Circle,
          .centre = centre + glm::dot(from, axis) * axis,
          .axis = axis,
          .along = radius > 0 ? flat / radius : AxisFrame(axis).x,
          .radius = radius,
          .minor = radius};
}

// Circles that a surface has through a point, whatever it meets: about its axis and around a tube;
// of spheres about what the other one tells.
void add_circles(const AnalyticSurface& surface, const AnalyticSurface& other, const glm::dvec3& p,
                 std::vector<BorderCurve>& circles) {
  if (has_axis(surface)) circles.push_back(circle_through(surface.origin, surface.axis, p));
  if (surface.kind == AnalyticKind::Torus) {
    const glm::dvec3 from = p - surface.origin;
    const glm::dvec3 flat = from - glm::dot(from, surface.axis) * surface.axis;
    if (glm::length(flat) > 0) {
      const glm::dvec3 away = glm::normalize(flat);
      circles.push_back(circle_through(surface.origin + surface.radius * away,
                                       glm::cross(surface.axis, away), p));
    }
  }
  if (surface.kind == AnalyticKind::Sphere) {
    if (other.kind != AnalyticKind::Sphere) {
      circles.push_back(circle_through(surface.origin, other.axis, p));
      // A tube that goes on as a ball: around the middle of the tube.
      if (other.kind == AnalyticKind::Torus) {
        const glm::dvec3 from = surface.origin - other.origin;
        if (glm::length(glm::cross(other.axis, from)) > 0)
          circles.push_back(
              circle_through(surface.origin, glm::normalize(glm::cross(other.axis, from)), p));
      }
    } else if (glm::length(other.origin - surface.origin) > 0) {
      circles.push_back(
          circle_through(surface.origin, glm::normalize(other.origin - surface.origin), p));
    }
  }
}

std::optional<BorderCurve> ellipse_of(const AnalyticSurface& plane, const AnalyticSurface& other) {
  if (plane.kind != AnalyticKind::Plane || other.kind != AnalyticKind::Cylinder)
    return std::nullopt;
  const double slant = glm::dot(plane.axis, other.axis);
  const glm::dvec3 across = glm::cross(plane.axis, other.axis);
  if (std::abs(slant) < 1e-3 || glm::length(across) < 1e-6) return std::nullopt;
  const double along = glm::dot(plane.origin - other.origin, plane.axis) / slant;
  const glm::dvec3 minor = glm::normalize(across);
  return BorderCurve{.kind = CurveKind::Ellipse,
                     .centre = other.origin + along * other.axis,
                     .axis = plane.axis,
                     .along = glm::cross(minor, plane.axis),
                     .radius = other.radius / std::abs(slant),
                     .minor = other.radius};
}

// So that it goes on from point to point.
void turn_along(BorderCurve& curve, std::span<const glm::dvec3> points) {
  double turn = 0;
  for (std::size_t i = 0; i + 1 < points.size(); ++i)
    turn +=
        glm::dot(curve.axis, glm::cross(points[i] - curve.centre, points[i + 1] - curve.centre));
  if (turn < 0) curve.axis = -curve.axis;
}

// Values at knot `at` of the three cubic B-splines that are not 0 there.
std::array<double, 3> values_at_knot(std::span<const double> knots, std::size_t at) {
  const auto knot = [&](std::ptrdiff_t i) {
    return knots[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(i, 0, std::ssize(knots) - 1))];
  };
  const auto i = static_cast<std::ptrdiff_t>(at);
  const double t = knot(i);
  // De Boor's triangle: degree 1 has one at t, degree 2 two, degree 3 three.
  const double l1 = t - knot(i - 1), r1 = knot(i + 1) - t, l2 = t - knot(i - 2),
               r2 = knot(i + 2) - t;
  const double a = r1 / (l1 + r1), b = l1 / (l1 + r1);
  return {a * r1 / (r1 + l2), a * l2 / (r1 + l2) + b * r2 / (r2 + l1), b * l1 / (r2 + l1)};
}

// The cubic spline through points at parameters, with these derivatives at its ends.
BorderCurve spline_through(std::span<const double> knots, std::span<const glm::dvec3> at,
                           const glm::dvec3& first, const glm::dvec3& last) {
  const std::size_t n = at.size() - 1;
  BorderCurve curve{.kind = CurveKind::Spline};
  curve.knots.assign(knots.begin(), knots.end());
  curve.points.assign(n + 3, glm::dvec3(0.0));
  curve.points[0] = at[0];
  curve.points[1] = at[0] + (knots[1] - knots[0]) / 3 * first;
  curve.points[n + 1] = at[n] - (knots[n] - knots[n - 1]) / 3 * last;
  curve.points[n + 2] = at[n];
  // Tridiagonal: point i + 1 is the middle one at knot i.
  std::vector<double> upper(n);
  std::vector<glm::dvec3> right(n);
  glm::dvec3 before = curve.points[1];
  double carried = 0;
  for (std::size_t i = 1; i < n; ++i) {
    const auto [a, b, c] = values_at_knot(knots, i);
    const double pivot = b - a * carried;
    glm::dvec3 value = at[i] - a * before;
    if (i + 1 == n) value -= c * curve.points[n + 1];
    upper[i] = c / pivot;
    right[i] = value / pivot;
    before = right[i];
    carried = upper[i];
  }
  for (std::size_t i = n; i-- > 1;)
    curve.points[i + 1] = right[i] - (i + 1 < n ? upper[i] * curve.points[i + 2] : glm::dvec3(0.0));
  return curve;
}

glm::dvec3 point_at(const BorderCurve& curve, double t) {
  return spline_point<kBorderDegree>(
      kBorderDegree, curve.knots, [&](std::size_t i) { return curve.points[i]; }, t);
}

// A spline on both surfaces within a distance: twice as many points until it is.
std::optional<BorderCurve> spline_along(const BorderSides& sides, std::span<const glm::dvec3> chain,
                                        double within) {
  std::vector<double> length{0};
  for (std::size_t i = 1; i < chain.size(); ++i)
    length.push_back(length.back() + glm::length(chain[i] - chain[i - 1]));
  if (!(length.back() > 0)) return std::nullopt;
  constexpr std::size_t kMostSpans = 2048;
  for (std::size_t spans = std::max<std::size_t>(8, chain.size() - 1); spans <= kMostSpans;
       spans *= 2) {
    std::vector<glm::dvec3> at{chain.front()};
    std::size_t piece = 1;
    for (std::size_t i = 1; i < spans; ++i) {
      const double wanted = length.back() * static_cast<double>(i) / static_cast<double>(spans);
      while (length[piece] < wanted) ++piece;
      const double part = (wanted - length[piece - 1]) / (length[piece] - length[piece - 1]);
      double reach = 0;
      at.push_back(sides.point((1 - part) * chain[piece - 1] + part * chain[piece], reach));
      if (!(reach <= within)) return std::nullopt;
    }
    at.push_back(chain.back());
    std::vector<double> knots{0};
    for (std::size_t i = 1; i < at.size(); ++i) {
      const double step = glm::length(at[i] - at[i - 1]);
      if (!(step > 0)) return std::nullopt;
      knots.push_back(knots.back() + step);
    }
    const auto tangent = [&](std::size_t i, const glm::dvec3& towards) {
      const glm::dvec3 cross =
          glm::cross(normal_at(*sides.left.surface, at[i]), normal_at(*sides.right.surface, at[i]));
      const glm::dvec3 chord = glm::normalize(towards);
      if (glm::length(cross) < 1e-4) return chord;
      const glm::dvec3 unit = glm::normalize(cross);
      return glm::dot(unit, chord) < 0 ? -unit : unit;
    };
    BorderCurve curve = spline_through(knots, at, tangent(0, at[1] - at[0]),
                                       tangent(spans, at[spans] - at[spans - 1]));
    double off = 0;
    for (std::size_t i = 0; i < spans; ++i) {
      for (const double part : {0.25, 0.5, 0.75}) {
        const glm::dvec3 p = point_at(curve, knots[i] + part * (knots[i + 1] - knots[i]));
        off = std::max({off, std::abs(signed_distance(*sides.left.surface, p)),
                        std::abs(signed_distance(*sides.right.surface, p))});
      }
    }
    if (off <= within) return curve;
  }
  return std::nullopt;
}

// Of unit length, of the curve that two surfaces have; 0 where they touch, or nearly.
glm::dvec3 tangent_at(const BorderSides& sides, const glm::dvec3& p) {
  constexpr double kTouch = 0.2;  // sine of the angle between them
  const glm::dvec3 t =
      glm::cross(normal_at(*sides.left.surface, p), normal_at(*sides.right.surface, p));
  return glm::length(t) > kTouch ? glm::normalize(t) : glm::dvec3(0.0);
}
// How far points go along that curve, ways back taken off: below 0 against its tangents.
double way_along(const BorderSides& sides, std::span<const glm::dvec3> points) {
  double way = 0;
  for (std::size_t i = 0; i + 1 < points.size(); ++i)
    way += glm::dot(tangent_at(sides, points[i]), points[i + 1] - points[i]);
  return way;
}
constexpr double kForward = 0.5;  // cosine of what goes on along a curve

// Without points that lie behind others along the curve: samples of either side of an edge come in
// any order.
std::vector<glm::dvec3> forward_of(const BorderSides& sides, std::span<const glm::dvec3> points) {
  const double sign = way_along(sides, points) < 0 ? -1 : 1;
  const auto goes_on = [&](const glm::dvec3& tangent, const glm::dvec3& step) {
    return sign * glm::dot(tangent, step) >= kForward * glm::length(tangent) * glm::length(step);
  };
  const glm::dvec3 target = points.back();
  std::vector<glm::dvec3> kept{points.front()};
  for (std::size_t i = 1; i + 1 < points.size(); ++i)
    if (goes_on(tangent_at(sides, kept.back()), points[i] - kept.back())) kept.push_back(points[i]);
  while (kept.size() > 1 && !goes_on(tangent_at(sides, target), target - kept.back()))
    kept.pop_back();
  kept.push_back(target);
  return kept;
}

// On both surfaces within a distance; none where there is none.
std::optional<BorderCurve> curve_within(const BorderSides& sides, std::span<const glm::dvec3> chain,
                                        double within) {
  const glm::dvec3 &from = chain.front(), &to = chain.back();
  // On both surfaces all along, and near the chain.
  const auto fits = [&](const BorderCurve& curve) {
    // A point where three surfaces touch one another is told by the square root of rounding.
    constexpr double kNear = 2e-3, kEnds = 5e-8;
    const auto on_surfaces = [&](const glm::dvec3& p) {
      return std::abs(signed_distance(*sides.left.surface, p)) <= within &&
             std::abs(signed_distance(*sides.right.surface, p)) <= within;
    };
    return distance_from(curve, from, to, from) <= kEnds &&
           distance_from(curve, from, to, to) <= kEnds &&
           std::ranges::all_of(
               chain,
               [&](const glm::dvec3& p) { return distance_from(curve, from, to, p) <= kNear; }) &&
           std::ranges::all_of(places_along(curve, from, to), on_surfaces);
  };
  const BorderCurve line{.kind = CurveKind::Line};
  if (glm::length(to - from) > kOnSurface && fits(line)) return line;
  std::vector<BorderCurve> curves;
  const AnalyticSurface &left = *sides.left.surface, &right = *sides.right.surface;
  add_circles(left, right, from, curves);
  add_circles(right, left, from, curves);
  for (const auto& [a, b] : {std::pair{&left, &right}, std::pair{&right, &left}})
    if (const auto ellipse = ellipse_of(*a, *b)) curves.push_back(*ellipse);
  for (BorderCurve& curve : curves) {
    if (!(curve.radius > 0)) continue;
    turn_along(curve, chain);
    if (fits(curve)) return curve;
  }
  return spline_along(sides, chain, within);
}

}  // namespace

bool comes_back(const BorderSides& sides, std::span<const glm::dvec3> chain) {
  double length = 0, told = 0;
  for (std::size_t i = 0; i + 1 < chain.size(); ++i) {
    const double step = glm::length(chain[i + 1] - chain[i]);
    length += step;
    told += glm::length(tangent_at(sides, chain[i])) * step;
  }
  return told > kForward * length && std::abs(way_along(sides, chain)) < kForward * told;
}

std::optional<BorderCurve> curve_along(const BorderSides& sides,
                                       std::span<const glm::dvec3> given) {
  const std::vector<glm::dvec3> chain = forward_of(sides, given);
  // Surfaces that cannot agree with all around them have the curve that is nearest to both.
  for (const double within : {kOnSurface, kOnAll})
    if (auto curve = curve_within(sides, chain, within)) return curve;
  return std::nullopt;
}

BorderCurve arc(const glm::dvec3& centre, const glm::dvec3& axis, const glm::dvec3& from) {
  return circle_through(centre, axis, from);
}

glm::dvec2 parameters_of(const AnalyticSurface& surface, const glm::dvec3& along, double height,
                         const glm::dvec3& point) {
  const glm::dvec3 from = point - surface.origin;
  const double x = glm::dot(from, along), y = glm::dot(from, glm::cross(surface.axis, along)),
               h = glm::dot(from, surface.axis);
  const double u = portable::atan2(y, x), radius = portable::hypot(x, y);
  switch (surface.kind) {
    case AnalyticKind::Plane:
      return {x, y};
    case AnalyticKind::Cylinder:
      return {u, h};
    case AnalyticKind::Cone:
      return {u, (h - height) * std::sqrt(1 + surface.slope * surface.slope)};
    case AnalyticKind::Sphere:
      return {u, portable::atan2(h, radius)};
    default:
      return {u, portable::atan2(h, radius - surface.radius)};
  }
}

ParameterWalk::ParameterWalk(const AnalyticSurface& surface, const glm::dvec3& along, double height,
                             const glm::dvec3& first)
    : surface_(surface),
      along_(along),
      height_(height),
      last_(parameters_of(surface, along, height, first)) {}

glm::dvec2 ParameterWalk::near_last(const glm::dvec3& place) const {
  glm::dvec2 uv = parameters_of(surface_, along_, height_, place);
  const auto near = [](double value, double other) {
    return other + std::remainder(value - other, 2 * std::numbers::pi);
  };
  if (surface_.kind != AnalyticKind::Plane) uv.x = near(uv.x, last_.x);
  if (surface_.kind == AnalyticKind::Torus) uv.y = near(uv.y, last_.y);
  return uv;
}

ParameterCurve parameter_curve(const AnalyticSurface& surface, const glm::dvec3& along,
                               double height, const BorderCurve& spline) {
  const std::vector<double>& knots = spline.knots;
  ParameterWalk walk(surface, along, height, spline.points.front());
  const auto at = [&](double t) { return walk.near_last(point_at(spline, t)); };
  // The ends' derivatives by differences of second order.
  constexpr double kStep = 1e-3;  // of a span
  const auto slope = [&](double t, double step) {
    return (4.0 * at(t + step) - at(t + 2 * step) - 3.0 * at(t)) / (2 * step);
  };
  const glm::dvec2 first = slope(knots.front(), kStep * (knots[1] - knots[0]));
  std::vector<glm::dvec3> places;
  for (const double t : knots) {
    places.emplace_back(walk.next(point_at(spline, t)), 0.0);
  }
  const glm::dvec2 end = slope(knots.back(), -kStep * (knots.back() - knots[knots.size() - 2]));
  ParameterCurve curve;
  for (const glm::dvec3& p :
       spline_through(knots, places, glm::dvec3(first, 0.0), glm::dvec3(end, 0.0)).points)
    curve.points.emplace_back(p.x, p.y);
  return curve;
}

std::vector<glm::dvec3> places_along(const BorderCurve& curve, const glm::dvec3& from,
                                     const glm::dvec3& to) {
  constexpr int kPlaces = 16;  // of a whole curve, and of each span
  std::vector<glm::dvec3> places;
  if (curve.kind == CurveKind::Spline) {
    for (std::size_t i = 0; i + 1 < curve.knots.size(); ++i)
      for (const double part : {0.0, 0.25, 0.5, 0.75})
        places.push_back(point_at(curve, (1 - part) * curve.knots[i] + part * curve.knots[i + 1]));
    return places;
  }
  if (curve.kind == CurveKind::Line) {
    for (int i = 1; i < kPlaces; ++i)
      places.push_back(from + static_cast<double>(i) / kPlaces * (to - from));
    return places;
  }
  const glm::dvec3 y = glm::cross(curve.axis, curve.along);
  const auto angle = [&](const glm::dvec3& p) {
    const glm::dvec3 off = p - curve.centre;
    return portable::atan2(glm::dot(off, y) / curve.minor,
                           glm::dot(off, curve.along) / curve.radius);
  };
  const double begin = angle(from);
  double turn = angle(to) - begin;
  if (turn <= 1e-12) turn += 2 * std::numbers::pi;
  for (int i = 1; i < kPlaces; ++i) {
    const double at = begin + turn * i / kPlaces;
    places.push_back(curve.centre + curve.radius * portable::cos(at) * curve.along +
                     curve.minor * portable::sin(at) * y);
  }
  return places;
}

double distance_from(const BorderCurve& curve, const glm::dvec3& from, const glm::dvec3& to,
                     const glm::dvec3& point) {
  switch (curve.kind) {
    case CurveKind::Line: {
      const glm::dvec3 along = glm::normalize(to - from);
      return glm::length(glm::cross(point - from, along));
    }
    case CurveKind::Circle:
    case CurveKind::Ellipse: {
      const glm::dvec3 off = point - curve.centre;
      const double height = glm::dot(off, curve.axis), x = glm::dot(off, curve.along),
                   y = glm::dot(off, glm::cross(curve.axis, curve.along));
      if (curve.kind == CurveKind::Circle)
        return portable::hypot(height, portable::hypot(x, y) - curve.radius);
      // To first order: by the value of the form over its gradient.
      const double form =
          x * x / (curve.radius * curve.radius) + y * y / (curve.minor * curve.minor) - 1;
      const double slope =
          2 * portable::hypot(x / (curve.radius * curve.radius), y / (curve.minor * curve.minor));
      return portable::hypot(height, slope > 0 ? form / slope : curve.minor);
    }
    default:
      return 0;
  }
}

}  // namespace planish
