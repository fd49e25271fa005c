#include "planish/patches/patch_curvature.h"

#include <cmath>
#include <glm/geometric.hpp>

namespace planish {

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
  const double half = 0.5 * (xx - yy), root = std::hypot(half, xy);
  result.largest = result.mean + root;
  result.smallest = result.mean - root;
  const double turn = 0.5 * std::atan2(xy, half);
  result.largest_direction = std::cos(turn) * along + std::sin(turn) * across;
  result.smallest_direction = glm::cross(normal, result.largest_direction);
  result.is_known = true;
  return result;
}

}  // namespace planish
