#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>
#include <limits>
#include <string>
#include <vector>

#include "planish/files/obj/obj_tags.h"
#include "planish/files/shared/text_lines.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// The colour of a vertex that has none; colours are not negative.
inline constexpr glm::vec4 kNoObjColor(-1.0f);

/// How much of an OBJ file stands before a place.
struct ObjCounts {
  std::int64_t line = 0, vertex = 0, uv = 0, face = 0, corner = 0;
};

/// Indices that count backwards from where nobody knows what stands before: from the part's first
/// vertex (coordinate), and below 0 before it.
struct ObjBackward {
  std::vector<std::size_t> corners;  ///< places in face_vertices or face_uvs
  std::int64_t lowest = std::numeric_limits<std::int64_t>::max();
};

/// What the reader of an OBJ file made the best of.
struct ObjNotes {
  LineNote unknown_keyword, bad_colors, bad_uvs, missing_uvs, continued_names, bad_positions;
  std::int64_t clamped_colors = 0;
};

/// What the lines of a part of an OBJ file say.
struct ObjPart {
  PolygonMesh mesh;  ///< offsets count from 0; colours and texture corners up to the last given
  std::vector<glm::dvec2> uvs;  ///< NaN: none
  ObjBackward backward_vertices, backward_uvs;

  struct Naming {
    enum class What : std::uint8_t { Object, Group, Material } what;
    std::int64_t faces_before;
    std::string name;
  };
  std::vector<Naming> namings;

  LargestIndex largest_vertex, largest_uv;
  ObjTagNotes tags;
  ObjNotes notes;
  std::vector<std::string> header;
  std::int64_t dropped_element_count = 0, line_count = 0;
  bool is_settled = false;  ///< what stands before was known: lines count from the file's beginning

  [[nodiscard]] ObjCounts counts() const;
};

/// Reads a part. `before`: what stands before it in the file; null where nobody knows yet, then
/// lines and elements count from the part, and indices may count back behind it.
/// Throws Error{UnreadableInput}.
[[nodiscard]] ObjPart read_obj_part(const TextLines& lines, const ObjCounts* before);

}  // namespace planish
