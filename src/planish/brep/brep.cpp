#include "planish/brep/brep.h"

#include <algorithm>
#include <array>
#include <span>

#include "planish/brep/square_piece.h"

namespace planish {
namespace {

// De Boor's scheme; point(i) is the control point i.
template <class Point>
glm::dvec3 spline_point(std::size_t degree, std::span<const double> knots, const Point& point,
                        double t) {
  const auto above = std::upper_bound(knots.begin() + 1, knots.end() - 1, t);
  const auto span = static_cast<std::size_t>(above - knots.begin()) - 1;
  // Those with their counts.
  const auto knot = [&](std::size_t k) {
    return knots[std::min(k < degree ? 0 : k - degree, knots.size() - 1)];
  };
  std::array<glm::dvec3, kMostSplineDegree + 1> left;
  for (std::size_t i = 0; i <= degree; ++i) left[i] = point(span + i);
  for (std::size_t r = 1; r <= degree; ++r) {
    for (std::size_t i = 0; i + r <= degree; ++i) {
      const double low = knot(span + i + r), high = knot(span + i + degree + 1);
      const double part = (t - low) / (high - low);
      left[i] = (1 - part) * left[i] + part * left[i + 1];
    }
  }
  return left[0];
}

}  // namespace

glm::dvec3 point_of(const Brep& brep, const Brep::Face& face, const glm::dvec2& at) {
  const std::size_t rows = point_count(brep.degree, face.knots_u);
  return spline_point(
      brep.degree, face.knots_v,
      [&](std::size_t j) {
        return spline_point(
            brep.degree, face.knots_u, [&](std::size_t i) { return face.points[i + rows * j]; },
            at.x);
      },
      at.y);
}

glm::dvec3 point_of(const Brep& brep, const Brep::Edge& edge, double t) {
  return spline_point(
      brep.degree, edge.knots, [&](std::size_t i) { return edge.points[i]; }, t);
}

}  // namespace planish
