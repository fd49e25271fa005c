#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <span>
#include <string>

#include "planish/mesh/mesh_file.h"

namespace planish {

/// What the writers see of a polygon mesh or a tessellated surface.
struct PolygonView {
  std::span<const glm::dvec3> positions;
  std::span<const glm::vec3> normals;          ///< empty, or one per position
  std::span<const std::int32_t> face_offsets;  ///< empty: every face has four corners
  std::span<const std::int32_t> face_vertices;
  std::span<const CreaseEdge> creases;
  std::span<const CornerVertex> corners;
  std::span<const std::string> header;  ///< comment lines, without the comment sign

  [[nodiscard]] std::size_t face_count() const {
    return face_offsets.empty() ? face_vertices.size() / 4 : face_offsets.size() - 1;
  }
  [[nodiscard]] std::span<const std::int32_t> face(std::size_t index) const {
    if (face_offsets.empty()) return face_vertices.subspan(4 * index, 4);
    return face_vertices.subspan(face_offsets[index],
                                 face_offsets[index + 1] - face_offsets[index]);
  }
};

/// Writes OBJ (`vn` for normals, `t` tags for creases and corners), PLY (binary little endian,
/// double positions, float `nx ny nz` for normals) or OFF (no normals) through OutputFile.
/// Throws Error{UnwritableOutput}; Error{InvalidArgument} for other formats, for positions that
/// are not finite and for header lines that hold a line break.
void write_polygons(const std::filesystem::path& path, MeshFormat format, const PolygonView& view);

}  // namespace planish
