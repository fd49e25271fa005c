#include "planish/analytic/analytic_surface.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <limits>

#include "planish/core/portable_math.h"
#include "planish/core/vectors.h"

namespace planish {
namespace {

constexpr double kNoFit = std::numeric_limits<double>::infinity();

// A point as a surface of revolution sees it: height along the axis, distance from it, and the
// direction away from it.
struct Meridian {
  double height = 0, radius = 0;
  glm::dvec3 away{};
};
Meridian meridian_of(const AnalyticSurface& surface, const glm::dvec3& point) {
  const glm::dvec3 from = point - surface.origin;
  const double height = glm::dot(from, surface.axis);
  const glm::dvec3 beside = from - height * surface.axis;
  const double radius = glm::length(beside);
  return {height, radius, radius > 0 ? beside / radius : AxisFrame(surface.axis).x};
}

// Of a ruling of a cone that rises by 1: one over the cosine of its angle.
double cone_length(const AnalyticSurface& cone) { return std::sqrt(1 + cone.slope * cone.slope); }

// Circle through points of a plane, by least squares of |p|^2 - 2 c p + k.
struct Circle {
  glm::dvec2 centre{};
  double radius = 0;
};
std::optional<Circle> circle_of(std::span<const glm::dvec2> points) {
  glm::dvec2 mean(0.0);
  for (const glm::dvec2& p : points) mean += p / static_cast<double>(points.size());
  std::vector<double> a(9), b(3);
  double size = 0;
  for (const glm::dvec2& p : points) size = std::max(size, glm::length(p - mean));
  if (!(size > 0)) return std::nullopt;
  for (const glm::dvec2& p : points) {
    const glm::dvec2 q = (p - mean) / size;
    const std::array<double, 3> row{2 * q.x, 2 * q.y, 1};
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) a[3 * i + j] += row[i] * row[j];
      b[i] += row[i] * glm::dot(q, q);
    }
  }
  if (!solve_cholesky(a, b)) return std::nullopt;
  const glm::dvec2 centre(b[0], b[1]);
  return Circle{mean + size * centre,
                size * std::sqrt(std::max(0.0, b[2] + glm::dot(centre, centre)))};
}

std::optional<AnalyticSurface> guess_plane(std::span<const glm::dvec3> points,
                                           std::span<const Facet> facets) {
  glm::dvec3 sum(0.0), mean(0.0);
  for (const Facet& facet : facets) sum += facet.area * facet.normal;
  for (const glm::dvec3& p : points) mean += p / static_cast<double>(points.size());
  if (!(glm::length(sum) > 0)) return std::nullopt;
  return AnalyticSurface{.kind = AnalyticKind::Plane, .origin = mean, .axis = glm::normalize(sum)};
}

// The normals' mean, and their spread around `about`: eigenvalues on the diagonal.
glm::dmat3 spread_of(std::span<const Facet> facets, const glm::dvec3& about) {
  glm::dmat3 spread(0.0);
  for (const Facet& facet : facets) {
    const glm::dvec3 n = facet.normal - about;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) spread[i][j] += n[i] * n[j];
  }
  return spread;
}
glm::dvec3 least_direction(glm::dmat3 spread) {
  const glm::dmat3 axes = eigenvectors(spread);
  int least = 0;
  for (int i = 1; i < 3; ++i)
    if (spread[i][i] < spread[least][least]) least = i;
  return glm::normalize(axes[least]);
}

std::optional<AnalyticSurface> guess_cylinder(std::span<const glm::dvec3> points,
                                              std::span<const Facet> facets) {
  const glm::dvec3 axis = least_direction(spread_of(facets, glm::dvec3(0.0)));
  const AxisFrame frame(axis);
  std::vector<glm::dvec2> flat;
  for (const glm::dvec3& p : points) flat.emplace_back(glm::dot(p, frame.x), glm::dot(p, frame.y));
  const auto circle = circle_of(flat);
  if (!circle) return std::nullopt;
  return AnalyticSurface{.kind = AnalyticKind::Cylinder,
                         .origin = circle->centre.x * frame.x + circle->centre.y * frame.y,
                         .axis = axis,
                         .radius = circle->radius};
}

// The cone about a direction by |q|^2 - (s h)^2 = 2 c q + k + 2 r s h, which is linear, for points
// that lie at q across it and h along it, with centre c and radius r + s h. Normals tell s^2: two
// rings of points do not.
std::optional<AnalyticSurface> cone_about(const glm::dvec3& axis,
                                          std::span<const glm::dvec3> points,
                                          std::span<const Facet> facets) {
  glm::dvec3 middle(0.0);
  for (const glm::dvec3& p : points) middle += p / static_cast<double>(points.size());
  double slant = 0;
  for (const Facet& facet : facets)
    slant += glm::dot(facet.normal, axis) / static_cast<double>(facets.size());
  if (!(std::abs(slant) < 0.999)) return std::nullopt;
  const double squared = slant * slant / (1 - slant * slant);
  const AxisFrame frame(axis);
  std::vector<double> a(16), b(4);
  double size = 0;
  for (const glm::dvec3& p : points) size = std::max(size, glm::length(p - middle));
  if (!(size > 0)) return std::nullopt;
  for (const glm::dvec3& p : points) {
    const glm::dvec3 q = (p - middle) / size;
    const double h = glm::dot(q, axis), x = glm::dot(q, frame.x), y = glm::dot(q, frame.y);
    const std::array<double, 4> row{2 * x, 2 * y, 1, h};
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < 4; ++j) a[4 * i + j] += row[i] * row[j];
      b[i] += row[i] * (x * x + y * y - squared * h * h);
    }
  }
  if (!solve_cholesky(a, b)) return std::nullopt;
  const double r0 = std::sqrt(std::max(0.0, b[2] + b[0] * b[0] + b[1] * b[1]));
  if (!(r0 > 0)) return std::nullopt;
  const double slope = b[3] / (2 * r0);
  if (!(std::abs(slope) > 1e-7)) return std::nullopt;
  return AnalyticSurface{
      .kind = AnalyticKind::Cone,
      .origin = middle + size * (b[0] * frame.x + b[1] * frame.y - r0 / slope * axis),
      .axis = slope > 0 ? axis : -axis,
      .slope = std::abs(slope)};
}

// Tips of a cone's normals lie on a circle about its axis.
std::optional<AnalyticSurface> guess_cone(std::span<const glm::dvec3> points,
                                          std::span<const Facet> facets) {
  glm::dvec3 mean(0.0);
  for (const Facet& facet : facets) mean += facet.normal / static_cast<double>(facets.size());
  return cone_about(least_direction(spread_of(facets, mean)), points, facets);
}

std::optional<AnalyticSurface> guess_sphere(std::span<const glm::dvec3> points) {
  glm::dvec3 mean(0.0);
  for (const glm::dvec3& p : points) mean += p / static_cast<double>(points.size());
  double size = 0;
  for (const glm::dvec3& p : points) size = std::max(size, glm::length(p - mean));
  if (!(size > 0)) return std::nullopt;
  std::vector<double> a(16), b(4);
  for (const glm::dvec3& p : points) {
    const glm::dvec3 q = (p - mean) / size;
    const std::array<double, 4> row{2 * q.x, 2 * q.y, 2 * q.z, 1};
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < 4; ++j) a[4 * i + j] += row[i] * row[j];
      b[i] += row[i] * glm::dot(q, q);
    }
  }
  if (!solve_cholesky(a, b)) return std::nullopt;
  const glm::dvec3 centre(b[0], b[1], b[2]);
  return AnalyticSurface{
      .kind = AnalyticKind::Sphere,
      .origin = mean + size * centre,
      .radius = size * std::sqrt(std::max(0.0, b[3] + glm::dot(centre, centre)))};
}

// The axis that lines along the facets' normals meet: of lines (p, n) with moments p x n, which a
// line (a, b) meets where a (p x n) + b n = 0 (Pottmann and Wallner, Computational Line Geometry).
std::optional<AnalyticSurface> axis_of(std::span<const Facet> facets) {
  glm::dvec3 mean(0.0);
  double whole = 0;
  for (const Facet& facet : facets) {
    mean += facet.area * facet.centre;
    whole += facet.area;
  }
  if (!(whole > 0)) return std::nullopt;
  mean /= whole;
  glm::dmat3 mm(0.0), mn(0.0), nn(0.0);  // [column][row]: sums of m m', m n', n n'
  for (const Facet& facet : facets) {
    const glm::dvec3 m = glm::cross(facet.centre - mean, facet.normal), n = facet.normal;
    for (int i = 0; i < 3; ++i) {
      mm[i] += facet.area / whole * m[i] * m;
      mn[i] += facet.area / whole * n[i] * m;
      nn[i] += facet.area / whole * n[i] * n;
    }
  }
  if (!(std::abs(glm::determinant(nn)) > 1e-12)) return std::nullopt;
  const glm::dmat3 inverse = glm::inverse(nn);
  const glm::dmat3 rest = mm - mn * inverse * glm::transpose(mn);
  const glm::dvec3 axis = least_direction(rest);
  const glm::dvec3 moment = -(inverse * (glm::transpose(mn) * axis));
  return AnalyticSurface{.origin = mean + glm::cross(axis, moment), .axis = axis};
}

std::optional<AnalyticSurface> guess_torus(std::span<const glm::dvec3> points,
                                           const AnalyticSurface& around) {
  std::vector<glm::dvec2> flat;
  for (const glm::dvec3& p : points) {
    const Meridian at = meridian_of(around, p);
    flat.emplace_back(at.radius, at.height);
  }
  const auto circle = circle_of(flat);
  if (!circle || !(circle->centre.x > circle->radius)) return std::nullopt;
  return AnalyticSurface{.kind = AnalyticKind::Torus,
                         .origin = around.origin + circle->centre.y * around.axis,
                         .axis = around.axis,
                         .radius = circle->centre.x,
                         .minor = circle->radius};
}

}  // namespace

std::string_view name_of(AnalyticKind kind) {
  constexpr std::array<std::string_view, kAnalyticKinds> kNames{"plane", "cylinder", "cone",
                                                                "sphere", "torus"};
  return kNames[static_cast<std::size_t>(kind)];
}

AxisFrame::AxisFrame(const glm::dvec3& axis) {
  const glm::dvec3 size = glm::abs(axis);
  const glm::dvec3 other = size.x <= size.y && size.x <= size.z ? glm::dvec3(1, 0, 0)
                           : size.y <= size.z                   ? glm::dvec3(0, 1, 0)
                                                                : glm::dvec3(0, 0, 1);
  x = glm::normalize(glm::cross(other, axis));
  y = glm::cross(axis, x);
}

double signed_distance(const AnalyticSurface& surface, const glm::dvec3& point) {
  if (surface.kind == AnalyticKind::Plane) return glm::dot(point - surface.origin, surface.axis);
  if (surface.kind == AnalyticKind::Sphere)
    return glm::length(point - surface.origin) - surface.radius;
  const Meridian at = meridian_of(surface, point);
  switch (surface.kind) {
    case AnalyticKind::Cylinder:
      return at.radius - surface.radius;
    case AnalyticKind::Cone:
      return (at.radius - surface.slope * at.height) / cone_length(surface);
    default:
      return portable::hypot(at.radius - surface.radius, at.height) - surface.minor;
  }
}

glm::dvec3 normal_at(const AnalyticSurface& surface, const glm::dvec3& point) {
  if (surface.kind == AnalyticKind::Plane) return surface.axis;
  if (surface.kind == AnalyticKind::Sphere) {
    const glm::dvec3 from = point - surface.origin;
    const double length = glm::length(from);
    return length > 0 ? from / length : surface.axis;
  }
  const Meridian at = meridian_of(surface, point);
  switch (surface.kind) {
    case AnalyticKind::Cylinder:
      return at.away;
    case AnalyticKind::Cone:
      return (at.away - surface.slope * surface.axis) / cone_length(surface);
    default: {
      const double out = at.radius - surface.radius, length = portable::hypot(out, at.height);
      return length > 0 ? (out * at.away + at.height * surface.axis) / length : at.away;
    }
  }
}

glm::dvec3 nearest_point(const AnalyticSurface& surface, const glm::dvec3& point) {
  return point - signed_distance(surface, point) * normal_at(surface, point);
}

std::span<const std::uint8_t> changes_of(AnalyticKind kind) {
  static constexpr std::array<std::uint8_t, 3> kPlane{0, 1, 4};
  static constexpr std::array<std::uint8_t, 5> kCylinder{0, 1, 2, 3, 5};
  static constexpr std::array<std::uint8_t, 6> kCone{0, 1, 2, 3, 4, 5};
  static constexpr std::array<std::uint8_t, 4> kSphere{2, 3, 4, 5};
  static constexpr std::array<std::uint8_t, 7> kTorus{0, 1, 2, 3, 4, 5, 6};
  switch (kind) {
    case AnalyticKind::Plane:
      return kPlane;
    case AnalyticKind::Cylinder:
      return kCylinder;
    case AnalyticKind::Cone:
      return kCone;
    case AnalyticKind::Sphere:
      return kSphere;
    default:
      return kTorus;
  }
}

AnalyticSurface changed(const AnalyticSurface& surface, const SurfaceChange& by) {
  const AxisFrame frame(surface.axis);
  AnalyticSurface result = surface;
  result.origin += by[2] * frame.x + by[3] * frame.y + by[4] * surface.axis;
  const glm::dvec3 turn = by[0] * frame.x + by[1] * frame.y;
  result.axis = glm::normalize(surface.axis + glm::cross(turn, surface.axis));
  (surface.kind == AnalyticKind::Cone ? result.slope : result.radius) += by[5];
  result.minor += by[6];
  return result;
}

SurfaceChange distance_gradient(const AnalyticSurface& surface, const glm::dvec3& point) {
  const AxisFrame frame(surface.axis);
  const glm::dvec3 normal = normal_at(surface, point);
  const glm::dvec3 turned = glm::cross(point - surface.origin, normal);
  SurfaceChange result{-glm::dot(frame.x, turned),
                       -glm::dot(frame.y, turned),
                       -glm::dot(frame.x, normal),
                       -glm::dot(frame.y, normal),
                       -glm::dot(surface.axis, normal),
                       -1,
                       -1};
  if (surface.kind == AnalyticKind::Plane || surface.kind == AnalyticKind::Torus ||
      surface.kind == AnalyticKind::Cone) {
    const Meridian at = meridian_of(surface, point);
    if (surface.kind == AnalyticKind::Torus) result[5] = -glm::dot(normal, at.away);
    if (surface.kind == AnalyticKind::Cone)
      result[5] = -(at.height + surface.slope * at.radius) /
                  (cone_length(surface) * (1 + surface.slope * surface.slope));
  }
  return result;
}

double fit_surface(AnalyticSurface& surface, std::span<const glm::dvec3> points, double wanted) {
  const auto changes = changes_of(surface.kind);
  const std::size_t count = changes.size();
  if (points.size() < count) return kNoFit;
  glm::dvec3 mean(0.0);
  for (const glm::dvec3& p : points) mean += p / static_cast<double>(points.size());
  const auto beside = [&](AnalyticSurface& of) {
    if (of.kind == AnalyticKind::Plane)
      of.origin = mean - glm::dot(mean - of.origin, of.axis) * of.axis;
    if (of.kind == AnalyticKind::Cylinder)
      of.origin += glm::dot(mean - of.origin, of.axis) * of.axis;
  };
  const auto squares = [&](const AnalyticSurface& of) {
    double sum = 0;
    for (const glm::dvec3& p : points) {
      const double d = signed_distance(of, p);
      sum += d * d;
    }
    return sum;
  };
  beside(surface);
  double best = squares(surface), damping = 1e-4;
  constexpr int kMostSteps = 100;
  int idle = 0;
  const double count_of_points = static_cast<double>(points.size());
  constexpr int kFirstSteps = 9;
  constexpr double kFar = 100;  // times what is wanted
  for (int step = 0; step < kMostSteps && idle < 8 && damping < 1e8; ++step) {
    if (step == kFirstSteps && best > kFar * kFar * wanted * wanted * count_of_points)
      return kNoFit;
    std::vector<double> matrix(count * count), right(count);
    for (const glm::dvec3& p : points) {
      const SurfaceChange gradient = distance_gradient(surface, p);
      const double d = signed_distance(surface, p);
      for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t j = 0; j <= i; ++j)
          matrix[count * i + j] += gradient[changes[i]] * gradient[changes[j]];
        right[i] -= gradient[changes[i]] * d;
      }
    }
    for (std::size_t i = 0; i < count; ++i)
      matrix[count * i + i] += damping * matrix[count * i + i] + 1e-300;
    if (!solve_cholesky(matrix, right)) {
      damping = std::max(damping * 8, 1e-12);
      continue;
    }
    SurfaceChange by{};
    for (std::size_t i = 0; i < count; ++i) by[changes[i]] = right[i];
    AnalyticSurface next = changed(surface, by);
    beside(next);
    const double error = squares(next);
    if (!(error < best)) {
      damping = std::max(damping * 8, 1e-12);
      ++idle;
      continue;
    }
    const bool is_done = error > 0.999 * best;
    best = error;
    surface = next;
    damping *= 0.1;
    if (is_done && damping < 1e-6) break;
  }
  const bool is_sound =
      surface.kind == AnalyticKind::Plane   ? true
      : surface.kind == AnalyticKind::Cone  ? surface.slope > 1e-4 && surface.slope < 1e3
      : surface.kind == AnalyticKind::Torus ? surface.minor > 0 && surface.radius > surface.minor
                                            : surface.radius > 0;
  if (!is_sound) return kNoFit;
  double largest = 0;
  for (const glm::dvec3& p : points) {
    // Points of a cone's other half are on no cone.
    if (surface.kind == AnalyticKind::Cone && glm::dot(p - surface.origin, surface.axis) < 0)
      return kNoFit;
    largest = std::max(largest, std::abs(signed_distance(surface, p)));
  }
  return std::isfinite(largest) ? largest : kNoFit;
}

std::optional<AnalyticSurface> guess_surface(AnalyticKind kind, std::span<const glm::dvec3> points,
                                             std::span<const Facet> facets,
                                             const AnalyticSurface* around) {
  if (points.empty()) return std::nullopt;
  switch (kind) {
    case AnalyticKind::Plane:
      return guess_plane(points, facets);
    case AnalyticKind::Cylinder:
      return guess_cylinder(points, facets);
    case AnalyticKind::Cone:
      return around != nullptr ? cone_about(around->axis, points, facets)
                               : guess_cone(points, facets);
    case AnalyticKind::Sphere:
      return guess_sphere(points);
    default:
      if (around != nullptr) return guess_torus(points, *around);
      if (const auto axis = axis_of(facets)) return guess_torus(points, *axis);
      return std::nullopt;
  }
}

bool solve_cholesky(std::vector<double>& a, std::vector<double>& b) {
  const std::size_t n = b.size();
  // Scaled, so that pivots tell what is singular.
  std::vector<double> scale(n);
  for (std::size_t i = 0; i < n; ++i) {
    if (!(a[n * i + i] > 0)) return false;
    scale[i] = 1 / std::sqrt(a[n * i + i]);
  }
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j <= i; ++j) a[n * i + j] *= scale[i] * scale[j];
    b[i] *= scale[i];
  }
  constexpr double kSingular = 1e-14;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = a[n * i + j];
      for (std::size_t k = 0; k < j; ++k) sum -= a[n * i + k] * a[n * j + k];
      if (i == j) {
        if (!(sum > kSingular)) return false;
        a[n * i + i] = std::sqrt(sum);
      } else {
        a[n * i + j] = sum / a[n * j + j];
      }
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < i; ++k) b[i] -= a[n * i + k] * b[k];
    b[i] /= a[n * i + i];
  }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t k = i + 1; k < n; ++k) b[i] -= a[n * k + i] * b[k];
    b[i] /= a[n * i + i];
  }
  for (std::size_t i = 0; i < n; ++i) b[i] *= scale[i];
  return true;
}

}  // namespace planish
