// Based on: C. Ericson, "Real-Time Collision Detection", 2005, section 5.1.5 (regions of a triangle
// for the nearest point).
#include "planish/reconstruct/spatial_search.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <limits>

#include "planish/core/widest.h"

namespace planish {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

// A point beside a shape: from corner a, and along both edges there.
struct Seen {
  double x, y, z, d1, d2;
};

PLANISH_IN_LINE Seen see(const TriangleShape& s, double px, double py, double pz) {
  const double x = px - s.a.x, y = py - s.a.y, z = pz - s.a.z;
  return {x, y, z, s.ab.x * x + s.ab.y * y + s.ab.z * z, s.ac.x * x + s.ac.y * y + s.ac.z * z};
}

PLANISH_IN_LINE double squared(double x, double y, double z) { return x * x + y * y + z * z; }

PLANISH_IN_LINE double least(double a, double b) { return b < a ? b : a; }

// To the foot in the plane; infinite where that is outside.
PLANISH_IN_LINE double to_foot(const TriangleShape& s, const Seen& p) {
  const double v = s.acac * p.d1 - s.abac * p.d2, w = s.abab * p.d2 - s.abac * p.d1;
  const double vi = v * s.inverse_determinant, wi = w * s.inverse_determinant;
  const double rest = 1 - (v + w) * s.inverse_determinant;
  // Sums, for what only one of two ways needs would be a branch, and no vector.
  const double flat = s.inverse_determinant > 0 ? 0.0 : kInfinite;
  return squared(p.x - vi * s.ab.x - wi * s.ac.x, p.y - vi * s.ab.y - wi * s.ac.y,
                 p.z - vi * s.ab.z - wi * s.ac.z) +
         flat + (least(least(v, w), rest) >= 0 ? 0.0 : kInfinite);
}

PLANISH_IN_LINE double to_edge(double x, double y, double z, const glm::dvec3& edge, double along,
                               double squared_length) {
  const double share = along / squared_length;
  const double above = share > 0 ? share : 0.0;  // 0 / 0, too
  const double t = above < 1 ? above : 1.0;
  return squared(x - t * edge.x, y - t * edge.y, z - t * edge.z);
}

// Else the nearest point is on an edge.
PLANISH_IN_LINE double to_edges(const TriangleShape& s, const Seen& p) {
  const glm::dvec3 bc(s.ac.x - s.ab.x, s.ac.y - s.ab.y, s.ac.z - s.ab.z);
  const double x = p.x - s.ab.x, y = p.y - s.ab.y, z = p.z - s.ab.z;
  return least(
      least(to_edge(p.x, p.y, p.z, s.ab, p.d1, s.abab), to_edge(p.x, p.y, p.z, s.ac, p.d2, s.acac)),
      to_edge(x, y, z, bc, bc.x * x + bc.y * y + bc.z * z, s.abab - 2 * s.abac + s.acac));
}

}  // namespace

TriangleShape::TriangleShape(const glm::dvec3& corner, const glm::dvec3& b, const glm::dvec3& c)
    : a(corner), ab(b - corner), ac(c - corner) {
  abab = glm::dot(ab, ab);
  abac = glm::dot(ab, ac);
  acac = glm::dot(ac, ac);
  const double determinant = abab * acac - abac * abac;
  inverse_determinant = determinant > 0 ? 1 / determinant : 0;
}

double TriangleShape::squared_distance(const glm::dvec3& point) const {
  const Seen seen = see(*this, point.x, point.y, point.z);
  const double foot = to_foot(*this, seen);
  return foot < kInfinite ? foot : to_edges(*this, seen);
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

PLANISH_WIDEST void take_nearer(const TriangleShape& given, std::int32_t index, int count,
                                PointBatch& points) {
  const TriangleShape shape = given;  // stays in registers
  for (int i = 0; i < count; ++i) {
    const Seen seen = see(shape, points.x[i], points.y[i], points.z[i]);
    const double foot = to_foot(shape, seen), edges = to_edges(shape, seen);
    const double distance = foot < kInfinite ? foot : edges;
    const bool is_nearer = distance < points.squared_distance[i];
    points.squared_distance[i] = is_nearer ? distance : points.squared_distance[i];
    points.nearest[i] = is_nearer ? index : points.nearest[i];
  }
}

}  // namespace planish
