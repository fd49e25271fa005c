#include "make_scenes/obj_text.h"

#include <array>
#include <charconv>

#include "make_scenes/mesh_builder.h"
#include "planish/files/shared/srgb.h"

namespace planish::shapes {

namespace {

template <typename Number>
void append(std::string& text, Number number) {
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
  text += ' ';
  text.append(digits.data(), end);
}

}  // namespace

std::string obj_text(const PolygonMesh& mesh, std::string_view comment) {
  std::string text = "# ";
  text.append(comment);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    text += "\nv";
    for (int axis = 0; axis < 3; ++axis) append(text, mesh.positions[v][axis]);
    if (mesh.colors.empty()) continue;
    const glm::dvec4 color = srgb_of_linear(mesh.colors[v]);
    for (int i = 0; i < 3; ++i) append(text, rounded(color[i]));
  }
  for (const glm::dvec2& uv : mesh.uvs) {
    text += "\nvt";
    append(text, uv.x);
    append(text, uv.y);
  }
  std::int32_t group = -1;
  for (std::int32_t face = 0; face < mesh.face_count(); ++face) {
    if (!mesh.face_groups.empty() && mesh.face_groups[face] != group) {
      group = mesh.face_groups[face];
      text += "\ng " + mesh.groups[group].name + "\nusemtl " + mesh.groups[group].material;
    }
    text += "\nf";
    for (std::int32_t c = mesh.face_offsets[face]; c < mesh.face_offsets[face + 1]; ++c) {
      append(text, mesh.face_vertices[c] + 1);
      if (!mesh.face_uvs.empty()) (text += '/') += std::to_string(mesh.face_uvs[c] + 1);
    }
  }
  // Tags count vertices from 0, faces from 1.
  for (const CreaseEdge& crease : mesh.creases) {
    text += "\nt crease 2/1/0";
    append(text, crease.v0);
    append(text, crease.v1);
    append(text, crease.sharpness);
  }
  for (const CornerVertex& corner : mesh.corners) {
    text += "\nt corner 1/1/0";
    append(text, corner.vertex);
    append(text, corner.sharpness);
  }
  for (const std::int32_t face : mesh.hole_faces) {
    text += "\nt hole 1/0/0";
    append(text, face);
  }
  return text + "\n";
}

}  // namespace planish::shapes
