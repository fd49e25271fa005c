#include "planish/files/read_points.h"

#include "planish/core/error.h"
#include "planish/core/visible_text.h"
#include "planish/files/read_file.h"

namespace planish {

PointCloud read_points(std::span<const std::byte> bytes, std::string_view name, FileFormat format) {
  const FormatInfo& info = info_of(format);
  if (!info.read_points) {
    throw Error(ErrorCode::InvalidArgument, std::string(name) + ": ." + std::string(info.name) +
                                                " holds no points by themselves");
  }
  PointCloud cloud = info.read_points({.bytes = bytes, .name = name, .path = {}});
  recentre(cloud);
  return cloud;
}

PointCloud read_points(const std::filesystem::path& path) {
  const auto format = format_of(path);
  if (!format || !serves(*format, FormatUse::ReadPoints)) {
    throw Error(ErrorCode::InvalidArgument, visible(path) +
                                                ": the extension names no format of points (" +
                                                names_of(FormatUse::ReadPoints) + ")");
  }
  return read_points(read_file(path), visible(path), *format);
}

}  // namespace planish
