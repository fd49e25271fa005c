#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "planish/files/obj/obj_tags.h"
#include "planish/files/shared/text_lines.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// The colour of a vertex that has none; colours are not negative.
inline constexpr glm::vec4 kNoObjColor(-1.0f);

/// What the lines of a part of an OBJ file say. Parts know nothing of each other: whoever joins
/// them settles the numbers of lines, groups that go on, and indices that count backwards.
struct ObjPart {
  PolygonMesh mesh;  ///< offsets count from 0; colours and texture corners up to the last given
  std::vector<glm::dvec2> uvs;
  /// Corners that count backwards: their index is from the part's first vertex (coordinate), and
  /// below 0 before it.
  std::vector<std::size_t> backward_vertices, backward_uvs;

  struct Naming {
    enum class What : std::uint8_t { Object, Group, Material } what;
    std::int32_t faces_before;
    std::string name;
  };
  std::vector<Naming> namings;

  LargestIndex largest_vertex, largest_uv;
  UnknownWord unknown_keyword;
  std::vector<std::string> header;
  std::int64_t dropped_element_count = 0, clamped_colors = 0, line_count = 0;
};

/// Reads one part. Of one that is not the first, indices may count backwards into those before it.
/// Throws Error{UnreadableInput}, whose lines and faces are those of the part.
class ObjPartReader {
 public:
  ObjPartReader(const TextLines& lines, bool is_first)
      : lines_(lines), tags_(lines_, part_.mesh), is_first_(is_first) {}

  ObjPartReader(const ObjPartReader&) = delete;
  ObjPartReader& operator=(const ObjPartReader&) = delete;

  void read();

  [[nodiscard]] ObjPart& part() { return part_; }
  [[nodiscard]] const TextLines& lines() const { return lines_; }
  [[nodiscard]] const ObjTags& tags() const { return tags_; }

 private:
  void read_line();
  void read_comment();
  void read_vertex(Words words);
  void read_uv(Words words);
  void read_face(Words words);
  void read_corner(std::string_view word);
  std::int32_t zero_based(std::int64_t index, const char* what, std::size_t count,
                          LargestIndex& largest, std::vector<std::size_t>& backward);
  void read_other(std::string_view keyword);
  void name(ObjPart::Naming::What what, Words words);

  TextLines lines_;
  ObjPart part_;
  ObjTags tags_;
  bool is_first_;
};

}  // namespace planish
