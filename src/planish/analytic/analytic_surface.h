#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace planish {

inline constexpr double kDegree = std::numbers::pi / 180;

enum class AnalyticKind : std::uint8_t { Plane, Cylinder, Cone, Sphere, Torus };
inline constexpr std::size_t kAnalyticKinds = 5;
[[nodiscard]] std::string_view name_of(AnalyticKind kind);  ///< "plane"

/// A surface that CAD programs know by name. Its normals point along a plane's axis, else away from
/// the axis, the centre or the circle inside the tube.
struct AnalyticSurface {
  AnalyticKind kind = AnalyticKind::Plane;
  glm::dvec3 origin{};       ///< of a plane or on the axis; a cone's apex; a centre
  glm::dvec3 axis{0, 0, 1};  ///< of unit length; a cone opens along it
  double radius = 0;         ///< of a cylinder or sphere; of the circle inside a torus
  double minor = 0;          ///< of a torus' tube
  double slope = 0;          ///< of a cone: tangent of the angle between axis and rulings
};

/// Two unit vectors that make a right-handed frame with a unit vector.
struct AxisFrame {
  explicit AxisFrame(const glm::dvec3& axis);
  glm::dvec3 x, y;
};

/// Of a point, from a surface: above 0 on the side of its normals. To first order for none.
[[nodiscard]] double signed_distance(const AnalyticSurface& surface, const glm::dvec3& point);
/// The gradient of that distance, of unit length; a fixed one where there is none.
[[nodiscard]] glm::dvec3 normal_at(const AnalyticSurface& surface, const glm::dvec3& point);

/// Of the surface: the point nearest to one.
[[nodiscard]] glm::dvec3 nearest_point(const AnalyticSurface& surface, const glm::dvec3& point);

/// What changes a surface: turns about its frame's x and y through the origin, shifts along x, y
/// and the axis, then radius (or a cone's slope) and minor radius.
inline constexpr std::size_t kSurfaceChanges = 7;
using SurfaceChange = std::array<double, kSurfaceChanges>;
/// Those that change a surface of the kind; the others leave it as it is.
[[nodiscard]] std::span<const std::uint8_t> changes_of(AnalyticKind kind);
[[nodiscard]] AnalyticSurface changed(const AnalyticSurface& surface, const SurfaceChange& by);
/// Of signed_distance() by each change, those that leave the surface as it is included.
[[nodiscard]] SurfaceChange distance_gradient(const AnalyticSurface& surface,
                                              const glm::dvec3& point);

/// Least squares of the distances, from a surface that is near (Levenberg-Marquardt). The origin
/// of planes and cylinders is moved beside the points. Returns the largest distance; infinite where
/// the points do not tell the surface, or after some steps are not near `wanted`.
[[nodiscard]] double fit_surface(AnalyticSurface& surface, std::span<const glm::dvec3> points,
                                 double wanted = std::numeric_limits<double>::max());

/// A flat piece of a mesh.
struct Facet {
  glm::dvec3 normal{};  ///< of unit length
  double area = 0;
  glm::dvec3 centre{};
};

/// The surface of a kind that points and facets through them tell, before it is fitted; none where
/// they tell none. `around`: where it is known, the axis of a torus, which a cone or cylinder
/// through a ring of its facets tells, or the direction of a cone's.
[[nodiscard]] std::optional<AnalyticSurface> guess_surface(AnalyticKind kind,
                                                           std::span<const glm::dvec3> points,
                                                           std::span<const Facet> facets,
                                                           const AnalyticSurface* around = nullptr);

/// Solves a x = b by Cholesky's factors, in place; rows of `a` lie one after another. False where
/// `a` is not positive.
[[nodiscard]] bool solve_cholesky(std::vector<double>& a, std::vector<double>& b);

}  // namespace planish
