#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

namespace planish {

/// The two triangles of a quad as corner numbers 0 to 3, in the quad's winding. It is split on its
/// shorter diagonal, on the one from corner 0 where both are equal to kDiagonalTie; on the longer
/// one where only that keeps the triangles from facing opposite ways (a concave quad).
[[nodiscard]] std::array<std::uint8_t, 6> split_quad(const glm::dvec3& corner0,
                                                     const glm::dvec3& corner1,
                                                     const glm::dvec3& corner2,
                                                     const glm::dvec3& corner3);

/// Squared diagonals that differ by less than this fraction count as equal, so that rounding does
/// not decide how the quads of a regular grid are split. Far below what the eye can tell.
inline constexpr double kDiagonalTie = 1e-6;

/// Splits a polygon of n >= 3 corners into n - 2 triangles in its winding and writes their vertex
/// indices to `triangles` (3 (n - 2) entries). Concave polygons are cut by ear clipping in the
/// plane of the polygon's Newell normal; one that crosses itself there gets n - 2 triangles too,
/// though they overlap. Corners must index `positions`, which must be finite.
/// Source: Meisters, "Polygons have ears", 1975.
void triangulate(std::span<const std::int32_t> corners, std::span<const glm::dvec3> positions,
                 std::span<std::uint32_t> triangles);

}  // namespace planish
