#include "planish/files/read_points.h"

#include "planish/core/error.h"
#include "planish/core/visible_text.h"
#include "planish/files/mesh_file.h"
#include "planish/files/read_file.h"
#include "planish/files/shared/text_encoding.h"

namespace planish {

PointCloud read_points(const FileBytes& file, FileFormat format) {
  const FormatInfo& info = info_of(format);
  if (!info.read_points) {
    throw Error(
        ErrorCode::InvalidArgument,
        std::string(file.name) + ": ." + std::string(info.name) + " holds no points by themselves");
  }
  const TextFile text = text_file(file, format);
  PointCloud cloud = info.read_points(text.file);
  cloud.warnings.insert(cloud.warnings.begin(), text.warnings.begin(), text.warnings.end());
  recentre(cloud);
  return cloud;
}

PointCloud points_of(const MeshFile& file, std::string_view name) {
  PointCloud cloud = cloud_of(file.mesh.positions, name);
  cloud.normals = file.normals;
  cloud.colors = file.mesh.colors;
  return cloud;
}

PointCloud read_points(std::span<const std::byte> bytes, std::string_view name, FileFormat format) {
  return read_points(FileBytes{.bytes = bytes, .name = name, .path = {}}, format);
}

PointCloud read_points(const std::filesystem::path& path) {
  const auto format = format_of(path);
  if (!format || !serves(*format, FormatUse::ReadPoints)) {
    throw Error(ErrorCode::InvalidArgument, visible(path) +
                                                ": the extension names no format of points (" +
                                                names_of(FormatUse::ReadPoints) + ")");
  }
  const RawVector<std::byte> bytes = read_file(path);
  const std::string name = visible(path);
  return read_points(FileBytes{.bytes = bytes, .name = name, .path = path}, *format);
}

}  // namespace planish
