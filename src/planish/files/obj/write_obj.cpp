#include "planish/files/writers.h"

#include <string>

#include "planish/files/obj/material_library.h"
#include "planish/files/shared/attributes.h"
#include "planish/files/shared/ordered_stream.h"

namespace planish {
namespace {

// A float is written as the double that it is, so that no rounding happens twice on the way back.
double sharpness_of(float sharpness) { return written_sharpness(sharpness); }

void write_colored_position(FileBuffer& out, const glm::dvec3& position, const glm::vec4& color) {
  const glm::dvec4 encoded = srgb_of_linear(color);
  out.text("v ").number(position.x).text(" ").number(position.y).text(" ").number(position.z);
  for (int i = 0; i < (color.a == 1 ? 3 : 4); ++i) out.text(" ").number(encoded[i]);
  out.text("\n");
}

void write_corner(FileBuffer& out, const PolygonPiece& piece, std::size_t corner) {
  const PolygonView& view = piece.view;
  const std::int64_t vertex = std::int64_t{view.face_vertices[corner]} + 1;
  const std::int64_t uv = view.face_uvs.empty() ? 0 : std::int64_t{view.face_uvs[corner]} + 1;
  out.text(" ").number(vertex);
  if (uv > 0) out.text("/").number(uv);
  if (piece.totals.has_normals) out.text(uv > 0 ? "/" : "//").number(vertex);
}

void write_group_change(FileBuffer& out, const FaceGroup& from, const FaceGroup& to) {
  // Without a name they lead back to where a file begins.
  if (from.name != to.name)
    out.text("g").text(to.name.empty() ? "" : obj_line_name(to.name)).text("\n");
  if (from.material != to.material)
    out.text("usemtl").text(to.material.empty() ? "" : obj_line_name(to.material)).text("\n");
}

void write_obj_positions(FileBuffer& out, const PolygonView& view) {
  for (std::size_t i = 0; i < view.positions.size(); ++i) {
    if (view.colors.empty()) {
      write_position(out.text("v "), view.positions[i]);
    } else {
      write_colored_position(out, view.positions[i], view.colors[i]);
    }
  }
}

void write_obj_faces(FileBuffer& out, const PolygonPiece& piece) {
  const PolygonView& view = piece.view;
  const FaceGroup* group = &piece.before;
  std::size_t corner = 0;
  for (std::size_t face = 0; face < view.face_count(); ++face) {
    if (!view.face_groups.empty()) {
      const FaceGroup& next = view.groups[view.face_groups[face]];
      write_group_change(out, *group, next);
      group = &next;
    }
    out.text("f");
    for (const std::size_t end = corner + view.face(face).size(); corner < end; ++corner)
      write_corner(out, piece, corner);
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

void write_obj_piece(FileBuffer& out, const PolygonPiece& piece) {
  const PolygonView& view = piece.view;
  switch (piece.part) {
    case PolygonPart::Head:
      for (const std::string& line : view.header) out.text("# ").text(line).text("\n");
      break;
    case PolygonPart::Positions:
      write_obj_positions(out, view);
      break;
    case PolygonPart::Uvs:
      for (const glm::dvec2& uv : view.uvs)
        out.text("vt ").number(uv.x).text(" ").number(uv.y).text("\n");
      break;
    case PolygonPart::Normals:
      for (const glm::vec3& n : view.normals)
        out.text("vn ").number(n.x).text(" ").number(n.y).text(" ").number(n.z).text("\n");
      break;
    case PolygonPart::Faces:
      write_obj_faces(out, piece);
      break;
    case PolygonPart::Tail:
      write_obj_tags(out, view);
      break;
    default:
      break;
  }
}

}  // namespace

void write_obj(const PolygonStream& stream) {
  for (const PolygonPart part : kObjParts) {
    stream.part(part, [&](FileBuffer& out, const PolygonPiece& piece, RowRange) {
      write_obj_piece(out, piece);
      if (part == PolygonPart::Head && !stream.companion().empty())
        write_mtllib(out, stream.companion());
    });
  }
}

}  // namespace planish
