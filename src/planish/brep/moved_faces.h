#pragma once

#include <array>
#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "planish/brep/brep.h"

namespace planish {

/// A spline of degree 2 with distinct knots, the first and the last of which count 3 times.
struct QuadraticCurve {
  std::vector<double> knots;
  std::vector<glm::dvec3> points;

  [[nodiscard]] glm::dvec3 at(double t) const;
  /// The part of it between two parameters, from 0 on; backwards where `from` is above `to`.
  [[nodiscard]] QuadraticCurve part(double from, double to) const;
};

/// Control points of the spline that has the values of `at` at these knots and halfway between
/// them: `at` itself where that is such a spline.
[[nodiscard]] std::vector<glm::dvec3> quadratic_points(std::span<const double> knots,
                                                       const std::function<glm::dvec3(double)>& at);

/// The curve within `tolerance` of `target`: spans between these knots are halved until it is. None
/// where 2^-24 of a span is not enough, or 4,096 spans.
[[nodiscard]] std::optional<QuadraticCurve> curve_near(
    std::vector<double> knots, const std::function<glm::dvec3(double)>& target, double tolerance);

/// 1 at 0, without slope, and nothing from 1 on, in both directions: a spline of degree 2 with
/// knots -1, -1/2, 1/2 and 1.
[[nodiscard]] double fading(double t);
/// Adds the knots of fading(t - at) between the first and the last one.
void add_fading_knots(double at, std::vector<double>& knots);

/// How a side of a face moves; without knots it stays.
struct MovedSide {
  std::vector<double> knots;                     ///< in the face's parameter along it
  std::function<glm::dvec3(double)> shift = {};  ///< a spline of degree 2 with these knots
};

/// Moves the sides of a B-spline face (below, right, above, left), and all else by what that leaves
/// of it within one unit of parameters: sides that stay, and what is farther in, do not move.
void move_sides(const Brep& brep, const std::array<MovedSide, 4>& sides, Brep::Face& face);

}  // namespace planish
