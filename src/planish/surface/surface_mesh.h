#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// A tessellation whose every vertex lies on the limit surface, in model coordinates. At level 0
/// its faces are the input's polygons, from level 1 on all quads.
struct SurfaceMesh {
  int level = 0;
  std::vector<glm::dvec3> positions;
  std::vector<glm::vec3> normals;           ///< unit, finite, one per position
  std::vector<std::int32_t> face_offsets;   ///< level 0 only: face_count + 1
  std::vector<std::int32_t> face_vertices;  ///< level 0: all corners; else 4 per quad
  /// The first positions are the limit points of the input's vertices, in its order: entry i is
  /// the input's index of position i (unused vertices are left out). Vertices of several normals
  /// (creases) have their further copies at the end.
  std::vector<std::int32_t> base_vertices;

  // The mesh's attributes, refined with it; empty where it has none.
  std::vector<glm::dvec2> uvs;         ///< texture coordinates, which face_uvs names
  std::vector<std::int32_t> face_uvs;  ///< one per corner, as face_vertices
  std::vector<glm::vec4> colors;       ///< linear RGBA, one per position
  std::vector<FaceGroup> groups;
  std::vector<std::int32_t> face_groups;  ///< one per face: its group

  [[nodiscard]] std::int64_t face_count() const {
    return level == 0 ? static_cast<std::int64_t>(face_offsets.size()) - 1
                      : static_cast<std::int64_t>(face_vertices.size()) / 4;
  }
  [[nodiscard]] std::span<const std::int32_t> face(std::int64_t index) const {
    const std::int64_t first = level == 0 ? face_offsets[index] : 4 * index;
    const std::int64_t size = level == 0 ? face_offsets[index + 1] - first : 4;
    return {face_vertices.data() + first, static_cast<std::size_t>(size)};
  }
};

}  // namespace planish
