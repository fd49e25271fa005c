// Based on: C. Ericson, "Real-Time Collision Detection", 2005, section 5.1.5 (regions of a triangle
// for the nearest point).
#include "planish/reconstruct/point_carrier.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <limits>

namespace planish {

TriangleShape::TriangleShape(const glm::dvec3& corner, const glm::dvec3& b, const glm::dvec3& c)
    : a(corner), ab(b - corner), ac(c - corner) {
  abab = glm::dot(ab, ab);
  abac = glm::dot(ab, ac);
  acac = glm::dot(ac, ac);
  const double determinant = abab * acac - abac * abac;
  inverse_determinant = determinant > 0 ? 1 / determinant : 0;
}

double TriangleShape::squared_distance(const glm::dvec3& point) const {
  const glm::dvec3 ap = point - a;
  const double d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap);
  const double v = acac * d1 - abac * d2, w = abab * d2 - abac * d1;
  // Inside: barycentric coordinates of the foot.
  if (inverse_determinant > 0 && v >= 0 && w >= 0 && (v + w) * inverse_determinant <= 1) {
    const glm::dvec3 rest = ap - (v * inverse_determinant) * ab - (w * inverse_determinant) * ac;
    return glm::dot(rest, rest);
  }
  // Outside the nearest point is on an edge.
  const auto to_segment = [](const glm::dvec3& p, const glm::dvec3& edge, double along,
                             double squared_length) {
    const double t = squared_length > 0 ? std::clamp(along / squared_length, 0.0, 1.0) : 0.0;
    const glm::dvec3 rest = p - t * edge;
    return glm::dot(rest, rest);
  };
  const glm::dvec3 bc = ac - ab, bp = ap - ab;
  return std::min({to_segment(ap, ab, d1, abab), to_segment(ap, ac, d2, acac),
                   to_segment(bp, bc, glm::dot(bc, bp), abab - 2 * abac + acac)});
}

glm::dvec3 TriangleShape::shares(const glm::dvec3& point) const {
  if (!(inverse_determinant > 0)) return glm::dvec3(1.0 / 3);
  const glm::dvec3 ap = point - a;
  const double d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap);
  const double v = std::max((acac * d1 - abac * d2) * inverse_determinant, 0.0);
  const double w = std::max((abab * d2 - abac * d1) * inverse_determinant, 0.0);
  const double u = std::max(1 - v - w, 0.0);
  return glm::dvec3(u, v, w) / (u + v + w);
}

std::int64_t find_nearest_shapes(const OrderedPoints& positions,
                                 std::span<const std::int32_t> points,
                                 std::span<const TriangleShape> shapes, double squared_tolerance,
                                 std::vector<std::int32_t>& nearest) {
  nearest.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const glm::dvec3 point = positions[points[i]];
    double best = std::numeric_limits<double>::infinity();
    for (std::size_t s = 0; s < shapes.size(); ++s) {
      const double squared = shapes[s].squared_distance(point);
      if (squared >= best) continue;
      best = squared;
      nearest[i] = static_cast<std::int32_t>(s);
    }
    if (!(best <= squared_tolerance)) return static_cast<std::int64_t>(i);
  }
  return -1;
}

}  // namespace planish
