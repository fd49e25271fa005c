#include "planish/limit/cell_bound.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

#include "planish/core/assert.h"

namespace planish {
namespace {

// Beyond it a piece is no height field worth the name.
constexpr double kLeastCosine = 0.3;

// The mean direction and the least cosine to it; below 0 where there is none.
struct Cone {
  glm::dvec3 axis{0.0};
  double cosine = -1;
};

Cone cone_of(std::span<const glm::dvec3> directions) {
  Cone cone;
  for (const glm::dvec3& d : directions) cone.axis += d;
  const double length = glm::length(cone.axis);
  if (!(length > 0)) return cone;
  cone.axis /= length;
  double least = 1;
  for (const glm::dvec3& d : directions) {
    const double size = glm::length(d);
    if (!(size > 0)) return cone;
    least = std::min(least, glm::dot(d, cone.axis) / size);
  }
  cone.cosine = least;
  return cone;
}

// Between any two of its directions.
double turn_of(const Cone& cone) {
  return cone.cosine > 0 ? 2 * std::acos(std::min(cone.cosine, 1.0)) : std::numbers::pi;
}

double slope(double cosine) { return std::sqrt(std::max(0.0, 1 - cosine * cosine)) / cosine; }

// The largest of some second derivatives: whole, along the cone's axis each way, and across it.
struct Largest {
  double whole = 0, up = 0, down = 0, across = 0;

  void add(const glm::dvec3& d, const glm::dvec3& axis) {
    const double height = glm::dot(d, axis);
    whole = std::max(whole, glm::length(d));
    up = std::max(up, height);
    down = std::max(down, -height);
    across = std::max(across, glm::length(d - height * axis));
  }
  [[nodiscard]] double along() const { return std::max(up, down); }
};

}  // namespace

void add_normals(const BezierNet& net, std::span<glm::dvec3, 36> normals) {
  std::size_t at = 0;
  for (std::size_t j = 0; j < 3; ++j) {
    for (std::size_t i = 0; i < 2; ++i) {
      const glm::dvec3 du = net[3 * j + i + 1] - net[3 * j + i];
      for (std::size_t l = 0; l < 2; ++l) {
        for (std::size_t k = 0; k < 3; ++k)
          normals[at++] = glm::cross(du, net[3 * (l + 1) + k] - net[3 * l + k]);
      }
    }
  }
}

double spread_of(std::span<const glm::dvec3> directions) { return turn_of(cone_of(directions)); }

CellBound bound_of(const BezierNet& net) {
  const BoundPiece piece{net, 1, 1};
  return bound_of(std::span(&piece, 1));
}

CellBound bound_of(std::span<const BoundPiece> pieces) {
  std::array<glm::dvec3, 36 * kMostPieces> normals;
  std::size_t count = 0;
  for (const BoundPiece& piece : pieces) {
    add_normals(piece.net, std::span(normals).subspan(count).first<36>());
    count += 36;
  }
  const Cone cone = cone_of(std::span(normals).first(count));
  Largest uu, uv, vv;
  for (const auto& [net, u, v] : pieces) {
    for (std::size_t k = 0; k < 3; ++k) {
      uu.add(u * u * 2.0 * (net[3 * k] - 2.0 * net[3 * k + 1] + net[3 * k + 2]), cone.axis);
      vv.add(v * v * 2.0 * (net[k] - 2.0 * net[k + 3] + net[k + 6]), cone.axis);
    }
    for (const std::size_t k : {0, 1, 3, 4})
      uv.add(u * v * 4.0 * (net[k + 4] - net[k + 3] - net[k + 1] + net[k]), cone.axis);
  }
  CellBound bound;
  bound.distance = (uu.whole + 2 * uv.whole + vv.whole) / 8;
  bound.turn = turn_of(cone);
  bound.by_uu = uu.whole / 8;
  bound.by_vv = vv.whole / 8;
  if (cone.cosine > kLeastCosine) {
    const double steep = slope(cone.cosine);
    // Where u and v are curved against one another, what they are off by is too.
    const double height = (std::max(uu.up + vv.up, uu.down + vv.down) + 2 * uv.along()) / 8;
    // So far along the surface, which rises by no more than its slope on the way.
    const double aside = (uu.across + 2 * uv.across + vv.across) / 8;
    const double with_slope = height + steep * aside;
    if (with_slope < bound.distance) {
      bound.distance = with_slope;
      bound.by_uu = uu.along() / 8;
      bound.by_vv = vv.along() / 8;
    }
  }
  bound.u_is_worse = bound.by_uu > bound.by_vv;
  return bound;
}

double curve_bound(std::span<const BezierCurve> curves) {
  std::array<glm::dvec3, 4> tangents;
  PLANISH_ASSERT(2 * curves.size() <= tangents.size());
  std::size_t count = 0;
  for (const auto& [a, b, c] : curves) {
    tangents[count++] = b - a;
    tangents[count++] = c - b;
  }
  const Cone cone = cone_of(std::span(tangents).first(count));
  double bound = 0;
  for (const auto& [a, b, c] : curves) {
    const glm::dvec3 second = 2.0 * (a - 2.0 * b + c) / 8.0;
    const double whole = glm::length(second);
    double of_curve = whole;
    if (cone.cosine > kLeastCosine) {
      const double along = glm::dot(second, cone.axis);
      const double across = glm::length(second - along * cone.axis);
      of_curve = std::min(whole, across + slope(cone.cosine) * std::abs(along));
    }
    bound = std::max(bound, of_curve);
  }
  return bound;
}

CellBound hull_bound(std::span<const glm::dvec3> points, std::span<const glm::dvec3> normals,
                     double aside) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  const Cone cone = cone_of(normals);
  glm::dvec3 low(kFar), high(-kFar);
  double lowest = kFar, highest = -kFar;
  for (const glm::dvec3& p : points) {
    for (int d = 0; d < 3; ++d) {
      low[d] = std::min(low[d], p[d]);
      high[d] = std::max(high[d], p[d]);
    }
    const double height = glm::dot(p, cone.axis);
    lowest = std::min(lowest, height);
    highest = std::max(highest, height);
  }
  CellBound bound{.distance = glm::length(high - low), .turn = turn_of(cone)};
  if (!(glm::dot(cone.axis, cone.axis) > 0.5)) return bound;
  // Surface and triangles are both within the slab. What of the surface is beside the triangles is
  // over those of the neighbours, which begin at the same chords and rise by no more than its
  // slope.
  const double steep = slope(std::max(cone.cosine, kLeastCosine));
  bound.distance = std::min(bound.distance, highest - lowest + steep * aside);
  return bound;
}

}  // namespace planish
