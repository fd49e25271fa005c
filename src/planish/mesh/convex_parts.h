#pragma once

#include <cstddef>
#include <functional>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

namespace planish {

/// Parts that a polygon falls into, as corner numbers in its winding, in no order: its Delaunay
/// triangulation less the diagonals that no corner needs, the longest first. They are at most four
/// times as many as the least possible. Time of the order of n log n for most polygons.
///
/// `polygon`: the places of its n corners, counter-clockwise; where it crosses itself parts may
/// overlap. `allowed`: n angles in radians; corners have no wider ones in a part unless the polygon
/// has only room for those. `may_cut(i, j)`: whether a diagonal may stay between these corners.
/// Source: Hertel and Mehlhorn, "Fast triangulation of simple polygons", 1983.
[[nodiscard]] std::vector<std::vector<std::size_t>> convex_parts(
    std::span<const glm::dvec2> polygon, std::span<const double> allowed,
    const std::function<bool(std::size_t, std::size_t)>& may_cut);

}  // namespace planish
