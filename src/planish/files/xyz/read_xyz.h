#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "planish/files/point_cloud.h"

namespace planish {

enum class TextPoints {
  Xyz,  ///< a point a line; a first line of words (column names) and `//` comments are passed over
  Pts,  ///< the same, where a line of one integer stands before the points that it counts
};

/// Points as text: x y z separated by blanks, commas or semicolons; further columns are passed
/// over, lines of x, y and z with a `nan` are counted as missing. Exceptions as read_points().
[[nodiscard]] PointCloud read_xyz(std::span<const std::byte> bytes, std::string_view name,
                                  TextPoints kind);

}  // namespace planish
