#pragma once

#include <array>
#include <cstdint>

#include "planish/mesh/polygon_mesh.h"

namespace planish::test {

/// Each quad as two triangles, by whatever diagonal; other faces stay.
inline PolygonMesh cut_quads(const PolygonMesh& mesh) {
  PolygonMesh cut = mesh;
  cut.face_vertices.clear();
  cut.face_offsets = {0};
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto v = mesh.face(f);
    if (v.size() != 4) {
      cut.add_face(v);
      continue;
    }
    const std::size_t i = (static_cast<std::uint32_t>(f) * 2654435761u >> 16) & 1;
    cut.add_face(std::array{v[i], v[i + 1], v[i + 2]});
    cut.add_face(std::array{v[i], v[i + 2], v[(i + 3) % 4]});
  }
  return cut;
}

}  // namespace planish::test
