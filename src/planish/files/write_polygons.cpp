#include "planish/files/write_polygons.h"

#include <algorithm>
#include <cmath>

#include "planish/core/error.h"
#include "planish/files/shared/file_buffer.h"
#include "planish/files/shared/srgb.h"

namespace planish {
namespace {

void write_position(FileBuffer& out, const glm::dvec3& position) {
  out.number(position.x).text(" ").number(position.y).text(" ").number(position.z).text("\n");
}

// A float is written as the double that it is, so that no rounding happens twice on the way back.
double sharpness_of(float sharpness) {
  return std::isfinite(sharpness) ? sharpness : kInfiniteSharpness;
}

void write_colored_position(FileBuffer& out, const glm::dvec3& position, const glm::vec4& color) {
  const glm::dvec4 encoded = srgb_of_linear(color);
  out.text("v ").number(position.x).text(" ").number(position.y).text(" ").number(position.z);
  for (int i = 0; i < (color.a == 1 ? 3 : 4); ++i) out.text(" ").number(encoded[i]);
  out.text("\n");
}

void write_corner(FileBuffer& out, const PolygonView& view, std::size_t corner) {
  const std::int64_t vertex = std::int64_t{view.face_vertices[corner]} + 1;
  const std::int64_t uv = view.face_uvs.empty() ? 0 : std::int64_t{view.face_uvs[corner]} + 1;
  out.text(" ").number(vertex);
  if (uv > 0) out.text("/").number(uv);
  if (!view.normals.empty()) out.text(uv > 0 ? "/" : "//").number(vertex);
}

// A name as OBJ can hold it: a reader takes a word with `#` for a comment and a backslash at the
// end for a continuation.
std::string line_name(const std::string& name) {
  std::string line = " " + name;
  for (std::size_t i = 1; i < line.size(); ++i) {
    const auto c = static_cast<unsigned char>(line[i]);
    if (c < ' ' || c == 0x7f || (c == '#' && line[i - 1] == ' ')) line[i] = '_';
  }
  if (line.ends_with('\\')) line.back() = '_';
  return line;
}

void write_group_change(FileBuffer& out, const FaceGroup& from, const FaceGroup& to) {
  // Without a name they lead back to where a file begins.
  if (from.name != to.name)
    out.text("g").text(to.name.empty() ? "" : line_name(to.name)).text("\n");
  if (from.material != to.material)
    out.text("usemtl").text(to.material.empty() ? "" : line_name(to.material)).text("\n");
}

void write_obj_faces(FileBuffer& out, const PolygonView& view) {
  FaceGroup group;
  std::size_t corner = 0;
  for (std::size_t face = 0; face < view.face_count(); ++face) {
    if (!view.face_groups.empty()) {
      const FaceGroup& next = view.groups[view.face_groups[face]];
      write_group_change(out, group, next);
      group = next;
    }
    out.text("f");
    for (const std::size_t end = corner + view.face(face).size(); corner < end; ++corner)
      write_corner(out, view, corner);
    out.text("\n");
  }
}

void write_obj_tags(FileBuffer& out, const PolygonView& view) {
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
  for (const std::int32_t face : view.hole_faces) out.text("t hole 1/0/0 ").number(face).text("\n");
}

void write_obj(FileBuffer& out, const PolygonView& view) {
  for (const std::string& line : view.header) out.text("# ").text(line).text("\n");
  for (std::size_t i = 0; i < view.positions.size(); ++i) {
    if (view.colors.empty()) {
      write_position(out.text("v "), view.positions[i]);
    } else {
      write_colored_position(out, view.positions[i], view.colors[i]);
    }
  }
  for (const glm::dvec2& uv : view.uvs)
    out.text("vt ").number(uv.x).text(" ").number(uv.y).text("\n");
  for (const glm::vec3& normal : view.normals)
    out.text("vn ").number(normal.x).text(" ").number(normal.y).text(" ").number(normal.z).text(
        "\n");
  write_obj_faces(out, view);
  write_obj_tags(out, view);
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
  if (!view.colors.empty())
    out.text(
        "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n");
  out.text("element face ").number(view.face_count());
  out.text(short_counts ? "\nproperty list uchar" : "\nproperty list int");
  out.text(" int vertex_indices\nend_header\n");
  for (std::size_t i = 0; i < view.positions.size(); ++i) {
    const glm::dvec3& position = view.positions[i];
    out.binary(position.x).binary(position.y).binary(position.z);
    if (!view.normals.empty()) {
      const glm::vec3& normal = view.normals[i];
      out.binary(normal.x).binary(normal.y).binary(normal.z);
    }
    if (!view.colors.empty()) {
      const glm::dvec4 encoded = srgb_of_linear(view.colors[i]);
      for (int k = 0; k < 4; ++k)
        out.binary(static_cast<std::uint8_t>(std::lround(255 * encoded[k])));
    }
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
