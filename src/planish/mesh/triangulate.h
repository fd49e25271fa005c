#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

namespace planish {

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
