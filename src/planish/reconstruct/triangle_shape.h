#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

namespace planish {

/// Three positions with what distance queries need, computed once.
struct TriangleShape {
  TriangleShape(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c);
  /// Squared distance of a point to the closed triangle.
  [[nodiscard]] double squared_distance(const glm::dvec3& point) const;
  /// Barycentric coordinates of a point's foot in the plane, none below 0; thirds where the
  /// triangle has no area.
  [[nodiscard]] glm::dvec3 shares(const glm::dvec3& point) const;

  glm::dvec3 a, ab, ac;
  double abab, abac, acac, inverse_determinant;
};

inline constexpr int kPointLanes = 128;

/// Points side by side, each with the nearest of the shapes that it has been shown.
struct PointBatch {
  double x[kPointLanes], y[kPointLanes], z[kPointLanes];
  double squared_distance[kPointLanes];
  std::int32_t nearest[kPointLanes];
};

/// Takes the shape, by the name `index`, for the first `count` points that are nearer to it than to
/// any before; distances are those of TriangleShape::squared_distance() to the last bit.
void take_nearer(const TriangleShape& shape, std::int32_t index, int count, PointBatch& points);

}  // namespace planish
