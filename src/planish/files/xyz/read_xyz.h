#pragma once

#include <cstddef>

#include "planish/files/shared/text_lines.h"
#include "planish/mesh/point_cloud.h"

namespace planish {

/// Points as text: x y z separated by blanks, commas or semicolons, then what PointColumns says;
/// lines of x, y and z with a `nan` are counted as missing. A first line of words or a comment
/// before the points may name the columns; other such lines are passed over. The result does not
/// depend on `part_bytes`, which a thread reads at a time. Exceptions as read_points().
[[nodiscard]] PointCloud read_xyz(const FileBytes& file, std::size_t part_bytes = kTextPartBytes);

/// The same, where a line of one integer stands before the points that it counts, and one column
/// behind x, y and z is intensity, four are intensity, red, green and blue.
[[nodiscard]] PointCloud read_pts(const FileBytes& file, std::size_t part_bytes = kTextPartBytes);

}  // namespace planish
