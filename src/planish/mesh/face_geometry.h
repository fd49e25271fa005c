#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/core/portable_math.h"

namespace planish {

/// In radians, 0 to pi, of vectors of any length; 0 where one has none.
[[nodiscard]] inline double angle_between(const glm::dvec3& a, const glm::dvec3& b) {
  if (glm::length(a) == 0 || glm::length(b) == 0) return 0;
  return portable::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

/// The vector area of a polygon: along its Newell normal, as long as the area it encloses where it
/// is flat. Any number of corners; zero for fewer than three.
[[nodiscard]] inline glm::dvec3 area_vector(std::span<const glm::dvec3> positions,
                                            std::span<const std::int32_t> vertices) {
  glm::dvec3 area(0.0);
  for (std::size_t i = 1; i + 1 < vertices.size(); ++i) {
    area += 0.5 * glm::cross(positions[vertices[i]] - positions[vertices[0]],
                             positions[vertices[i + 1]] - positions[vertices[0]]);
  }
  return area;
}

/// Twice the signed area of the triangle that a and b span: positive where b lies left of a.
[[nodiscard]] inline double cross(const glm::dvec2& a, const glm::dvec2& b) {
  return a.x * b.y - a.y * b.x;
}

/// Twice the signed area of a, b, c: positive where they turn left.
[[nodiscard]] inline double turn(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
  return cross(b - a, c - a);
}

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

/// The n - 2 triangles of a polygon of n >= 3 corners, as corner numbers in its winding, by ear
/// clipping, the ear with the smallest circle first: nearly a Delaunay triangulation, and of round
/// polygons one of even pieces. `polygon`: the places of its corners, counter-clockwise. One that
/// crosses itself gets n - 2 triangles too, though they overlap. Time of the order of n log n for
/// most polygons.
/// Source: Meisters, "Polygons have ears", 1975.
[[nodiscard]] std::vector<std::array<std::uint32_t, 3>> clip_ears(
    std::span<const glm::dvec2> polygon);

/// The two triangles of a quad as corner numbers 0 to 3, in the quad's winding,
/// cut as is_cut_from_1() says.
[[nodiscard]] std::array<std::uint8_t, 6> split_quad(const glm::dvec3& corner0,
                                                     const glm::dvec3& corner1,
                                                     const glm::dvec3& corner2,
                                                     const glm::dvec3& corner3);

/// Splits a polygon of n >= 3 corners into n - 2 triangles in its winding and writes their vertex
/// indices to `triangles` (3 (n - 2) entries). Concave polygons are cut by ear clipping in the
/// plane of the polygon's Newell normal; one that crosses itself there gets n - 2 triangles too,
/// though they overlap. Corners must index `positions`, which must be finite.
/// Source: Meisters, "Polygons have ears", 1975.
void triangulate(std::span<const std::int32_t> corners, std::span<const glm::dvec3> positions,
                 std::span<std::uint32_t> triangles);

}  // namespace planish
