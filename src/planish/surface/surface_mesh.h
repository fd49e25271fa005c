#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace planish {

/// A tessellation whose every vertex lies on the limit surface, in model coordinates. At level 0
/// its faces are the input's polygons, from level 1 on all quads.
struct SurfaceMesh {
  int level = 0;
  std::vector<glm::dvec3> positions;
  std::vector<glm::vec3> normals;            ///< unit, finite, one per position
  std::vector<std::int32_t> face_offsets;    ///< level 0 only: face_count + 1
  std::vector<std::int32_t> face_vertices;   ///< level 0: all corners; else 4 per quad
  /// The first `base_vertex_count` positions are the limit points of the input's vertices, in
  /// its order. Vertices of several normals (creases) have their further copies at the end.
  std::int32_t base_vertex_count = 0;

  [[nodiscard]] std::int64_t face_count() const {
    return level == 0 ? static_cast<std::int64_t>(face_offsets.size()) - 1
                      : static_cast<std::int64_t>(face_vertices.size()) / 4;
  }
};

}  // namespace planish
