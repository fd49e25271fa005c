#include "planish/brep/brep.h"

#include <algorithm>
#include <cstddef>
#include <span>

namespace planish {
namespace {

// De Boor's scheme of degree 2; point(i) is the control point i.
template <class Point>
glm::dvec3 spline_point(std::span<const double> knots, const Point& point, double t) {
  const std::size_t last = knots.size() - 1;
  const auto above = std::upper_bound(knots.begin() + 1, knots.end() - 1, t);
  const auto k = static_cast<std::size_t>(above - knots.begin()) - 1;
  const double from = knots[k], to = knots[k + 1];
  const double before = knots[k == 0 ? 0 : k - 1], after = knots[std::min(k + 2, last)];
  const auto between = [t](const glm::dvec3& a, const glm::dvec3& b, double low, double high) {
    const double part = (t - low) / (high - low);
    return (1 - part) * a + part * b;
  };
  const glm::dvec3 middle = point(k + 1);
  return between(between(point(k), middle, before, to), between(middle, point(k + 2), from, after),
                 from, to);
}

}  // namespace

glm::dvec3 point_of(const Brep::Face& face, const glm::dvec2& at) {
  const std::size_t rows = face.knots_u.size() + 1;
  return spline_point(
      face.knots_v,
      [&](std::size_t j) {
        return spline_point(
            face.knots_u, [&](std::size_t i) { return face.points[i + rows * j]; }, at.x);
      },
      at.y);
}

glm::dvec3 point_of(const Brep::Edge& edge, double t) {
  return spline_point(
      edge.knots, [&](std::size_t i) { return edge.points[i]; }, t);
}

}  // namespace planish
