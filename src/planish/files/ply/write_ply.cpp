#include "planish/files/ply/write_ply.h"

#include <algorithm>
#include <cmath>

#include "planish/files/shared/srgb.h"

namespace planish {

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
  for (const NamedField& field : view.fields)
    out.text("property float ").text(field.name).text("\n");
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
    for (const NamedField& field : view.fields) out.binary(field.values[i]);
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

}  // namespace planish
