#include "planish/files/write_polygons.h"

#include <cmath>
#include <limits>

#include "planish/core/error.h"
#include "planish/core/visible_text.h"
#include "planish/files/shared/file_buffer.h"

namespace planish {
namespace {

bool fits_float(const glm::dvec3& p) {
  constexpr double kMost = std::numeric_limits<float>::max();
  return std::abs(p.x) <= kMost && std::abs(p.y) <= kMost && std::abs(p.z) <= kMost;
}

void require_writable(const std::string& name, const FormatInfo& info, const PolygonView& view) {
  for (const std::string& line : view.header)
    if (line.find_first_of("\r\n") != std::string::npos)
      throw Error(ErrorCode::InvalidArgument, name + ": a header line holds a line break");
  for (std::size_t i = 0; i < view.positions.size(); ++i) {
    const glm::dvec3& p = view.positions[i];
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
      throw Error(ErrorCode::InvalidArgument,
                  name + ": vertex " + std::to_string(i) + " is not finite",
                  static_cast<std::int64_t>(i));
    if (!info.keeps_doubles && !fits_float(p))
      throw Error(ErrorCode::InvalidArgument,
                  name + ": vertex " + std::to_string(i) +
                      " has a coordinate that float32 cannot hold; scale the model down",
                  static_cast<std::int64_t>(i));
  }
  for (std::size_t i = 0; i < view.uvs.size(); ++i) {
    if (!std::isfinite(view.uvs[i].x) || !std::isfinite(view.uvs[i].y))
      throw Error(ErrorCode::InvalidArgument,
                  name + ": texture coordinate " + std::to_string(i) + " is not finite",
                  static_cast<std::int64_t>(i));
  }
  for (std::size_t i = 0; i < view.colors.size(); ++i) {
    const glm::vec4& c = view.colors[i];
    if (!std::isfinite(c.r) || !std::isfinite(c.g) || !std::isfinite(c.b) || !std::isfinite(c.a))
      throw Error(ErrorCode::InvalidArgument,
                  name + ": the colour of vertex " + std::to_string(i) + " is not finite",
                  static_cast<std::int64_t>(i));
  }
}

}  // namespace

void write_polygons(const std::filesystem::path& path, FileFormat format, const PolygonView& view) {
  const FormatInfo& info = info_of(format);
  if (!info.write_polygons)
    throw Error(ErrorCode::InvalidArgument, visible(path) + ": polygons are written as " +
                                                extensions_in_words(FormatUse::WriteCage) +
                                                ", not as ." + std::string(info.name));
  require_writable(visible(path), info, view);
  OutputFile file(path);
  FileBuffer out(file);
  info.write_polygons(out, view);
  out.finish();
}

}  // namespace planish
