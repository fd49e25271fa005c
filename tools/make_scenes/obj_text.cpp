#include "make_scenes/obj_text.h"

#include <array>
#include <charconv>

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
  for (const glm::dvec3& position : mesh.positions) {
    text += "\nv";
    for (int axis = 0; axis < 3; ++axis) append(text, position[axis]);
  }
  for (std::int32_t face = 0; face < mesh.face_count(); ++face) {
    text += "\nf";
    for (const std::int32_t vertex : mesh.face(face)) append(text, vertex + 1);
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
  return text + "\n";
}

}  // namespace planish::shapes
