#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "planish/mesh/point_cloud.h"

namespace planish {

/// PCD (Point Cloud Library) up to version 0.7: ascii, binary and binary_compressed; x, y and z of
/// any scalar type, normal_x, normal_y and normal_z as floats, rgb or rgba packed in 32 bits of
/// sRGB; the file's byte order is little endian. The viewpoint tells where the sensor stood and
/// moves nothing. Points with a nan are counted as missing. Exceptions as read_points().
[[nodiscard]] PointCloud read_pcd(std::span<const std::byte> bytes, std::string_view name);

}  // namespace planish
