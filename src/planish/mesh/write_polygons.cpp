#include "planish/mesh/write_polygons.h"

#include <algorithm>
#include <cmath>

#include "planish/core/error.h"
#include "planish/mesh/file_buffer.h"

namespace planish {
namespace {

void write_position(FileBuffer& out, const glm::dvec3& position) {
  out.number(position.x).text(" ").number(position.y).text(" ").number(position.z).text("\n");
}

// A float is written as the double that it is, so that no rounding happens twice on the way back.
double sharpness_of(float sharpness) {
  return std::isfinite(sharpness) ? sharpness : kInfiniteSharpness;
}

void write_obj(FileBuffer& out, const PolygonView& view) {
  for (const std::string& line : view.header) out.text("# ").text(line).text("\n");
  for (const glm::dvec3& position : view.positions) write_position(out.text("v "), position);
  for (const glm::vec3& normal : view.normals)
    out.text("vn ").number(normal.x).text(" ").number(normal.y).text(" ").number(normal.z).text(
        "\n");
  for (std::size_t face = 0; face < view.face_count(); ++face) {
    out.text("f");
    for (const std::int32_t vertex : view.face(face)) {
      const std::int64_t index = std::int64_t{vertex} + 1;
      out.text(" ").number(index);
      if (!view.normals.empty()) out.text("//").number(index);
    }
    out.text("\n");
  }
  for (const CreaseEdge& crease : view.creases)
    out.text("t crease 2/1/0 ")
        .number(crease.v0)
        .text(" ")
        .number(crease.v1)
        .text(" ")
        .number(sharpness_of(crease.sharpness))
        .text("\n");
  for (const CornerVertex& corner : view.corners)
    out.text("t corner 1/1/0 ")
        .number(corner.vertex)
        .text(" ")
        .number(sharpness_of(corner.sharpness))
        .text("\n");
}

void write_ply(FileBuffer& out, const PolygonView& view) {
  std::size_t largest = 0;
  for (std::size_t face = 0; face < view.face_count(); ++face)
    largest = std::max(largest, view.face(face).size());
  const bool short_counts = largest <= 255;
  out.text("ply\nformat binary_little_endian 1.0\n");
  for (const std::string& line : view.header) out.text("comment ").text(line).text("\n");
  out.text("element vertex ").number(view.positions.size());
  out.text("\nproperty double x\nproperty double y\nproperty double z\n");
  if (!view.normals.empty()) out.text("property float nx\nproperty float ny\nproperty float nz\n");
  out.text("element face ").number(view.face_count());
  out.text(short_counts ? "\nproperty list uchar" : "\nproperty list int");
  out.text(" int vertex_indices\nend_header\n");
  for (std::size_t i = 0; i < view.positions.size(); ++i) {
    const glm::dvec3& position = view.positions[i];
    out.binary(position.x).binary(position.y).binary(position.z);
    if (view.normals.empty()) continue;
    const glm::vec3& normal = view.normals[i];
    out.binary(normal.x).binary(normal.y).binary(normal.z);
  }
  for (std::size_t face = 0; face < view.face_count(); ++face) {
    const auto corners = view.face(face);
    if (short_counts) {
      out.binary(static_cast<std::uint8_t>(corners.size()));
    } else {
      out.binary(static_cast<std::int32_t>(corners.size()));
    }
    for (const std::int32_t vertex : corners) out.binary(vertex);
  }
}

void write_off(FileBuffer& out, const PolygonView& view) {
  out.text("OFF\n");
  for (const std::string& line : view.header) out.text("# ").text(line).text("\n");
  out.number(view.positions.size()).text(" ").number(view.face_count()).text(" 0\n");
  for (const glm::dvec3& position : view.positions) write_position(out, position);
  for (std::size_t face = 0; face < view.face_count(); ++face) {
    const auto corners = view.face(face);
    out.number(corners.size());
    for (const std::int32_t vertex : corners) out.text(" ").number(vertex);
    out.text("\n");
  }
}

void require_writable(const std::string& name, const PolygonView& view) {
  for (const std::string& line : view.header)
    if (line.find_first_of("\r\n") != std::string::npos)
      throw Error(ErrorCode::InvalidArgument, name + ": a header line holds a line break");
  for (std::size_t i = 0; i < view.positions.size(); ++i) {
    const glm::dvec3& p = view.positions[i];
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
      throw Error(ErrorCode::InvalidArgument,
                  name + ": vertex " + std::to_string(i) + " is not finite",
                  static_cast<std::int64_t>(i));
  }
}

}  // namespace

void write_polygons(const std::filesystem::path& path, MeshFormat format, const PolygonView& view) {
  void (*write)(FileBuffer&, const PolygonView&) = nullptr;
  if (format == MeshFormat::Obj) write = write_obj;
  if (format == MeshFormat::Ply) write = write_ply;
  if (format == MeshFormat::Off) write = write_off;
  if (!write)
    throw Error(ErrorCode::InvalidArgument, path.string() + ": polygons are written as .obj, " +
                                                ".ply or .off, not as ." +
                                                std::string(name_of(format)));
  require_writable(path.string(), view);
  OutputFile file(path);
  FileBuffer out(file);
  write(out, view);
  out.finish();
}

}  // namespace planish
