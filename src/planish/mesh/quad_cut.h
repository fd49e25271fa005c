#pragma once

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace planish {

/// Squared diagonals that differ by less than this fraction count as equal, so that rounding does
/// not decide how the quads of a regular grid are split. Far below what the eye can tell.
inline constexpr double kDiagonalTie = 1e-6;

/// Whether a quad is cut from corner 1 to 3 and not from 0 to 2: on its shorter diagonal, from 0 to
/// 2 where both are equal to kDiagonalTie; on the longer one where only that keeps the triangles
/// from facing opposite ways (a concave quad).
[[nodiscard]] inline bool is_cut_from_1(const glm::dvec3& corner0, const glm::dvec3& corner1,
                                        const glm::dvec3& corner2, const glm::dvec3& corner3) {
  const glm::dvec3 from0 = corner2 - corner0, from1 = corner3 - corner1;
  const double squared0 = glm::dot(from0, from0), squared1 = glm::dot(from1, from1);
  // Facing of the two triangles at each diagonal, up to a positive factor. Most quads need one.
  const auto agree0 = [&] {
    return glm::dot(glm::cross(corner1 - corner0, from0), glm::cross(from0, corner3 - corner0));
  };
  const auto agree1 = [&] {
    return glm::dot(glm::cross(corner2 - corner1, from1), glm::cross(from1, corner0 - corner1));
  };
  const bool shorter_is_1 = squared1 < squared0 * (1.0 - kDiagonalTie);
  return shorter_is_1 ? !(agree1() < 0 && agree0() > 0) : agree0() < 0 && agree1() > 0;
}

}  // namespace planish
