#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "planish/mesh/point_cloud.h"

namespace planish {

/// Points as text: x y z separated by blanks, commas or semicolons; further columns are passed
/// over, lines of x, y and z with a `nan` are counted as missing. A first line of words (column
/// names) and `//` comments are passed over. Exceptions as read_points().
[[nodiscard]] PointCloud read_xyz(std::span<const std::byte> bytes, std::string_view name);

/// The same, where a line of one integer stands before the points that it counts.
[[nodiscard]] PointCloud read_pts(std::span<const std::byte> bytes, std::string_view name);

}  // namespace planish
