#pragma once

#include <array>
#include <glm/vec3.hpp>
#include <span>

namespace planish {

struct PatchForm;

/// Nine Bezier points of a piece of a patch, (i, j) at i + 3 j, i along u.
using BezierNet = std::array<glm::dvec3, 9>;

/// Of a patch that is one polynomial.
[[nodiscard]] BezierNet bezier_net(const PatchForm& form, std::span<const glm::dvec3> points);

/// A quarter, not turned.
[[nodiscard]] BezierNet net_quarter(BezierNet net, bool upper_u, bool upper_v);

/// The net of the same piece as a patch sees it that is turned against it by so many quarters.
[[nodiscard]] BezierNet turned_net(const BezierNet& net, int turns);

/// The blossom of a quadratic by its Bezier points: at (t, t) its point at t.
[[nodiscard]] inline glm::dvec3 quadratic_blossom(const glm::dvec3& a, const glm::dvec3& b,
                                                  const glm::dvec3& c, double s, double t) {
  return (1 - t) * ((1 - s) * a + s * b) + t * ((1 - s) * b + s * c);
}

/// The part between two places along u or v, of 0 to 1.
[[nodiscard]] BezierNet net_between(const BezierNet& net, bool along_v, double from, double to);

}  // namespace planish
