#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <string>
#include <string_view>

#include "planish/files/formats.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/surface/vertex_fields.h"

namespace planish {

/// How a format that knows subdivision surfaces (USD) is to draw a cage.
struct CageSubdivision {
  std::string_view scheme = "none";  ///< "catmullClark", "loop"; "none" draws the polygons
  bool has_sharp_boundary_corners = false;
};

/// What the writers see of a polygon mesh or a tessellated surface.
struct PolygonView {
  std::span<const glm::dvec3> positions;
  std::span<const glm::vec3> normals;          ///< empty, or one per position
  std::span<const std::int32_t> face_offsets;  ///< empty: every face has four corners
  std::span<const std::int32_t> face_vertices;
  std::span<const CreaseEdge> creases;
  std::span<const CornerVertex> corners;
  std::span<const glm::dvec2> uvs;
  std::span<const std::int32_t> face_uvs;  ///< empty, or one per corner; -1: none there
  std::span<const glm::vec4> colors;       ///< empty, or one per position; linear RGBA
  std::span<const FaceGroup> groups;
  std::span<const std::int32_t> face_groups;  ///< empty, or one per face
  std::span<const std::int32_t> hole_faces;
  std::span<const NamedField> fields;   ///< one value per position each; PLY and USD only
  CageSubdivision subdivision;          ///< USD only
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

/// Writes the polygons through OutputFile as the format's own writer does (obj/write_obj.h,
/// ply/write_ply.h, off/write_off.h).
/// Throws Error{UnwritableOutput}; Error{InvalidArgument} for formats that are not written, for
/// numbers that are not finite and for header lines that hold a line break.
void write_polygons(const std::filesystem::path& path, FileFormat format, const PolygonView& view);

}  // namespace planish
