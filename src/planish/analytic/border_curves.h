#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "planish/analytic/analytic_surface.h"
#include "planish/analytic/settle_surfaces.h"

namespace planish {

enum class CurveKind : std::uint8_t { Line, Circle, Ellipse, Spline };

/// A curve that two surfaces share, from one point to another, or to the same one.
struct BorderCurve {
  CurveKind kind = CurveKind::Line;
  // Of circles and ellipses, which it goes along counter-clockwise about the axis; unit vectors.
  glm::dvec3 centre{}, axis{}, along{};  ///< the larger radius of an ellipse lies along
  double radius = 0, minor = 0;          ///< of a circle the same
  // Of splines, of degree 3: distinct knots from 0 on, the first and last of which count 4 times.
  std::vector<double> knots;
  std::vector<glm::dvec3> points;
};
inline constexpr std::size_t kBorderDegree = 3;

/// Of the diagonal: curves lie on their surfaces within this, or within kOnAll where they
/// have no such curve.
inline constexpr double kOnSurface = 1e-9;
/// Of the diagonal: a point is the one that surfaces have in common. Those of a mesh of rounded
/// coordinates may agree no better.
inline constexpr double kOnAll = 7e-8;

/// The curve along a chain: from its first point to its last, which lie on both surfaces, by those
/// between, which are near and may go back and forth. None where the surfaces do not meet along it.
[[nodiscard]] std::optional<BorderCurve> curve_along(const BorderSides& sides,
                                                     std::span<const glm::dvec3> chain);

/// Whether a closed chain goes along that curve and back, so that it is around nothing. Not where
/// the surfaces touch.
[[nodiscard]] bool comes_back(const BorderSides& sides, std::span<const glm::dvec3> chain);

/// An arc about an axis through `centre`, counter-clockwise from a point.
[[nodiscard]] BorderCurve arc(const glm::dvec3& centre, const glm::dvec3& axis,
                              const glm::dvec3& from);

/// A curve's place in the parameters of a surface, as STEP has these: (u, v), without turns between
/// one place and the next.
struct ParameterCurve {
  std::vector<glm::dvec2> points;  ///< of the spline's knots
};
/// Parameters of a point: the angle about the axis from `along`, and the height, of a cone
/// along its rulings from `height` on, of spheres the latitude, of tori the angle around the tube.
[[nodiscard]] glm::dvec2 parameters_of(const AnalyticSurface& surface, const glm::dvec3& along,
                                       double height, const glm::dvec3& point);
/// Of a spline on a surface. `height`: where a cone is placed.
[[nodiscard]] ParameterCurve parameter_curve(const AnalyticSurface& surface,
                                             const glm::dvec3& along, double height,
                                             const BorderCurve& spline);

/// The parameters of places on a surface that are passed in order, without turns between them.
class ParameterWalk {
 public:
  /// As parameters_of(). The surface must outlive it.
  ParameterWalk(const AnalyticSurface& surface, const glm::dvec3& along, double height,
                const glm::dvec3& first);
  [[nodiscard]] glm::dvec2 near_last(const glm::dvec3& place) const;
  glm::dvec2 next(const glm::dvec3& place) { return last_ = near_last(place); }

 private:
  const AnalyticSurface& surface_;
  glm::dvec3 along_;
  double height_;
  glm::dvec2 last_;
};

/// Places along a curve between its ends, near enough for its distance from a surface to be seen.
[[nodiscard]] std::vector<glm::dvec3> places_along(const BorderCurve& curve, const glm::dvec3& from,
                                                   const glm::dvec3& to);

/// How far a point is from a line through two others, a circle or an ellipse; 0 for splines.
[[nodiscard]] double distance_from(const BorderCurve& curve, const glm::dvec3& from,
                                   const glm::dvec3& to, const glm::dvec3& point);

}  // namespace planish
