#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// A tessellation whose every vertex lies on the limit surface, in model coordinates. At level 0
/// its faces are the input's polygons, from level 1 on all quads, or triangles with Loop. Rows and
/// faces of Doo-Sabin surfaces are numbered as PatchNumbering says; vertices that only holes name
/// are left out.
struct SurfaceMesh {
  int level = 0;
  RawVector<glm::dvec3> positions;
  RawVector<glm::vec3> normals;            ///< unit, finite, one per position
  std::vector<std::int32_t> face_offsets;  ///< face_count + 1; empty where all faces are quads
  RawVector<std::int32_t> face_vertices;   ///< all corners
  /// The first positions are the limit points of the input's vertices, in its order: entry i is
  /// the input's index of position i (unused vertices are left out). Vertices of several normals
  /// (creases) have their further copies at the end.
  std::vector<std::int32_t> base_vertices;

  // The mesh's attributes, refined with it; empty where it has none.
  RawVector<glm::dvec2> uvs;         ///< texture coordinates, which face_uvs names
  RawVector<std::int32_t> face_uvs;  ///< one per corner, as face_vertices
  RawVector<glm::vec4> colors;       ///< linear RGBA, one per position
  std::vector<VertexAttribute> attributes;
  std::vector<FaceGroup> groups;
  RawVector<std::int32_t> face_groups;  ///< one per face: its group

  [[nodiscard]] std::int64_t face_count() const {
    return face_offsets.empty() ? static_cast<std::int64_t>(face_vertices.size()) / 4
                                : static_cast<std::int64_t>(face_offsets.size()) - 1;
  }
  /// Of a level from 1 on: Loop's.
  [[nodiscard]] bool is_triangles() const { return level > 0 && !face_offsets.empty(); }
  [[nodiscard]] std::span<const std::int32_t> face(std::int64_t index) const {
    const std::int64_t first = face_offsets.empty() ? 4 * index : face_offsets[index];
    const std::int64_t size = face_offsets.empty() ? 4 : face_offsets[index + 1] - first;
    return {face_vertices.data() + first, static_cast<std::size_t>(size)};
  }
};

}  // namespace planish
