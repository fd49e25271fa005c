#pragma once

#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <iterator>
#include <limits>
#include <type_traits>

#include "planish/core/portable_math.h"

namespace planish {

/// 0 where the vector has no length.
[[nodiscard]] inline glm::dvec3 unit_or_zero(const glm::dvec3& vector) {
  const double length = glm::length(vector);
  return length > 0 ? vector / length : glm::dvec3(0.0);
}

/// The length of a vector whose squares may be too small or too large for double; infinite where a
/// coordinate is no finite number: of (0, NaN, 0) libstdc++'s hypot() says 0.
[[nodiscard]] inline double safe_length(const glm::dvec3& vector) {
  if (!std::isfinite(vector.x) || !std::isfinite(vector.y) || !std::isfinite(vector.z))
    return std::numeric_limits<double>::infinity();
  return portable::hypot(vector.x, vector.y, vector.z);
}

/// Of the box around points.
template <class Point>
struct PointBounds {
  Point low, high;
};

/// Of points of two or three coordinates; the origin where there are none.
template <class Points>
[[nodiscard]] auto point_bounds(const Points& points) {
  using Point = std::remove_cvref_t<decltype(*std::begin(points))>;
  if (std::begin(points) == std::end(points)) return PointBounds<Point>{Point(0), Point(0)};
  PointBounds<Point> box{*std::begin(points), *std::begin(points)};
  for (const Point& point : points) {
    box.low = glm::min(box.low, point);
    box.high = glm::max(box.high, point);
  }
  return box;
}

/// Eigenvectors of a symmetric matrix as columns, by cyclic Jacobi rotations; the eigenvalues stay
/// on the diagonal of `matrix`.
[[nodiscard]] glm::dmat3 eigenvectors(glm::dmat3& matrix);

}  // namespace planish
