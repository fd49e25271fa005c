#include "planish/files/ply/write_ply.h"

#include <cmath>

#include "planish/files/shared/srgb.h"

namespace planish {

namespace {

bool has_short_counts(const PolygonPiece& piece) { return piece.totals.largest_face <= 255; }

void write_ply_header(FileBuffer& out, const PolygonPiece& piece) {
  const PolygonTotals& totals = piece.totals;
  out.text("ply\nformat binary_little_endian 1.0\n");
  for (const std::string& line : piece.view.header) out.text("comment ").text(line).text("\n");
  out.text("element vertex ").number(totals.row_count);
  out.text("\nproperty double x\nproperty double y\nproperty double z\n");
  if (totals.has_normals) out.text("property float nx\nproperty float ny\nproperty float nz\n");
  if (totals.has_colors)
    out.text(
        "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n");
  for (const NamedField& field : piece.view.fields)
    out.text("property float ").text(field.name).text("\n");
  out.text("element face ").number(totals.face_count);
  out.text(has_short_counts(piece) ? "\nproperty list uchar" : "\nproperty list int");
  out.text(" int vertex_indices\nend_header\n");
}

void write_ply_vertices(FileBuffer& out, const PolygonView& view) {
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
    for (const NamedField& field : view.fields) out.binary(field.values[i]);
  }
}

void write_ply_faces(FileBuffer& out, const PolygonPiece& piece) {
  for (std::size_t face = 0; face < piece.view.face_count(); ++face) {
    const auto corners = piece.view.face(face);
    if (has_short_counts(piece)) {
      out.binary(static_cast<std::uint8_t>(corners.size()));
    } else {
      out.binary(static_cast<std::int32_t>(corners.size()));
    }
    for (const std::int32_t vertex : corners) out.binary(vertex);
  }
}

}  // namespace

bool is_ply_part(PolygonPart part) {
  return part == PolygonPart::Head || part == PolygonPart::Vertices || part == PolygonPart::Faces;
}

void write_ply(FileBuffer& out, const PolygonPiece& piece) {
  if (piece.part == PolygonPart::Head) write_ply_header(out, piece);
  if (piece.part == PolygonPart::Vertices) write_ply_vertices(out, piece.view);
  if (piece.part == PolygonPart::Faces) write_ply_faces(out, piece);
}

}  // namespace planish
