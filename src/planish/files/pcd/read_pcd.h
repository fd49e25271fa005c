#pragma once

#include <cstddef>

#include "planish/files/shared/text_lines.h"
#include "planish/mesh/point_cloud.h"

namespace planish {

/// PCD (Point Cloud Library) up to version 0.7: ascii, binary and binary_compressed; x, y and z of
/// any scalar type, normal_x, normal_y and normal_z as floats, rgb or rgba packed in 32 bits of
/// sRGB; the file's byte order is little endian. The viewpoint tells where the sensor stood and
/// moves nothing. Points with a nan are counted as missing. Lines of the header that begin with
/// other words are passed over with a warning, unless the file is strict or they may be a misspelt
/// count. The result does not depend on `part_bytes`, of which a thread reads about so many at a
/// time of text. Exceptions as read_points().
[[nodiscard]] PointCloud read_pcd(const FileBytes& file, std::size_t part_bytes = kTextPartBytes);

}  // namespace planish
