#pragma once

#include "planish/files/formats.h"
#include "planish/files/scan_contents.h"
#include "planish/mesh/point_cloud.h"

namespace planish {

/// LAS 1.0 to 1.4, not compressed: positions by the file's scale and offset, colours of 16 bits
/// (of 8, where none is above 255; none where all are 0), sRGB. Points that are withheld or
/// classified as noise are left out, with the warning "noise-points". Exceptions as read_points().
[[nodiscard]] PointCloud read_las(const FileBytes& file);

/// Flight lines by their number, classes by the standard's names. Exceptions as read_points().
[[nodiscard]] ScanContents las_contents(const FileBytes& file);

}  // namespace planish
