#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

namespace planish {

/// The n - 2 triangles of a polygon of n >= 3 corners, as corner numbers in its winding, by ear
/// clipping, the ear with the smallest circle first: nearly a Delaunay triangulation, and of round
/// polygons one of even pieces. `polygon`: the places of its corners, counter-clockwise. One that
/// crosses itself gets n - 2 triangles too, though they overlap. Time of the order of n log n for
/// most polygons.
/// Source: Meisters, "Polygons have ears", 1975.
[[nodiscard]] std::vector<std::array<std::uint32_t, 3>> clip_ears(
    std::span<const glm::dvec2> polygon);

}  // namespace planish
