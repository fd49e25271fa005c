#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <string_view>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/mesh/vertex_attribute.h"

namespace planish {

/// Unorganised points. Point i lies at origin + points[i]; both the subtraction that made
/// points[i] and this sum are exact, so that the file's doubles come back bit by bit.
struct PointCloud {
  std::vector<glm::dvec3> points;
  /// Of any length, 0 or not finite for none; empty, or one per point.
  std::vector<glm::vec3> normals;
  std::vector<glm::vec4> colors;            ///< linear RGBA, 0 to 1; empty, or one per point
  std::vector<VertexAttribute> attributes;  ///< further numbers of each point, as intensity
  /// 0 on an axis where the cloud is not far from 0, see recentre().
  glm::dvec3 origin{0.0};
  /// Points of the file that are not finite, as depth cameras write where they saw nothing.
  std::int64_t missing_count = 0;
  std::vector<Warning> warnings;
};

/// Distance of a cloud's centre from 0, in diagonals, from which on it is moved to the origin.
inline constexpr double kFarDiagonals = 10.0;

/// Moves a cloud without origin near 0 on each axis where its centre is more than kFarDiagonals
/// bounding-box diagonals away.
void recentre(PointCloud& cloud);

/// The positions as a cloud near 0. Throws Error{UnreadableInput} for one that is not finite or
/// beyond kMaxCoordinate: `name: point 12 of 345: ...`.
[[nodiscard]] PointCloud cloud_of(std::vector<glm::dvec3> positions, std::string_view name);

/// Length of the bounding box's diagonal; 0 for no points.
[[nodiscard]] double diagonal_of(std::span<const glm::dvec3> points);

}  // namespace planish
