#pragma once

#include <cstddef>
#include <functional>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

namespace planish {

/// By how many corners a polygon's lie turned at most from those of the affine regular polygon that
/// the steps of Doo and Sabin make of it: the largest angle about the mean, in the coordinates in
/// which that polygon is regular, by 2 pi / n. From about 8 on the lines of a surface that come
/// from the corners and from between them cross each other (tests/pipeline/fine_outlines_test.cpp).
/// 0 for affine regular polygons; half of n at most, and where that polygon is turned over or has
/// no area.
[[nodiscard]] double corner_swirl(std::span<const glm::dvec2> polygon);

/// From which corner_swirl() on faces are cut.
inline constexpr double kMostSwirl = 5;

/// Cuts a polygon without corners that turn inward by much until no part has more than kMostSwirl,
/// as far as it can be: finely drawn arcs off along their chords, and what is left in a row of
/// quads and triangles between its two sides.
/// `places`: of the corners that `part` names, counter-clockwise. `may_cut(i, j)`: whether a
/// diagonal may stay between these, asked once for each that is taken. Time of the order of n log
/// n.
[[nodiscard]] std::vector<std::vector<std::size_t>> even_parts(
    std::span<const glm::dvec2> places, std::vector<std::size_t> part,
    const std::function<bool(std::size_t, std::size_t)>& may_cut);

}  // namespace planish
