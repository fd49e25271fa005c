#include "planish/files/read_points.h"

#include "planish/core/error.h"
#include "planish/core/visible_text.h"
#include "planish/files/mesh_file.h"
#include "planish/files/read_file.h"
#include "planish/files/shared/read_counted.h"

namespace planish {

PointCloud read_points(const FileBytes& file, FileFormat format, const Callbacks& callbacks) {
  const FormatInfo& info = info_of(format);
  if (!info.read_points) {
    throw Error(ErrorCode::InvalidArgument,
                formatted("{}: .{} holds no points by themselves", file.name, info.name));
  }
  PointCloud cloud = read_counted(file, format, callbacks, info.read_points);
  recentre(cloud);
  return cloud;
}

PointCloud points_of(const MeshFile& file, std::string_view name) {
  PointCloud cloud = cloud_of(file.mesh.positions, name);
  cloud.missing_count = file.missing_count;
  cloud.normals = file.normals;
  cloud.colors = file.mesh.colors;
  cloud.attributes = file.mesh.attributes;
  return cloud;
}

PointCloud read_points(std::span<const std::byte> bytes, std::string_view name, FileFormat format) {
  return read_points(FileBytes{.bytes = bytes, .name = name, .path = {}}, format);
}

PointCloud read_points(const std::filesystem::path& path, const Callbacks& callbacks) {
  const auto format = format_of(path);
  if (!format || !serves(*format, FormatUse::ReadPoints)) {
    throw Error(ErrorCode::InvalidArgument,
                formatted("{}: the extension names no format of points ({})", visible(path),
                          names_of(FormatUse::ReadPoints)));
  }
  const RawVector<std::byte> bytes = read_file(path, share_of(callbacks, 0, kFileLoaded));
  const std::string name = visible(path);
  return read_points(FileBytes{.bytes = bytes, .name = name, .path = path}, *format,
                     share_of(callbacks, kFileLoaded, 1));
}

}  // namespace planish
