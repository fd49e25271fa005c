#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "planish/files/mesh_file.h"
#include "planish/files/shared/text_lines.h"

namespace planish {

/// The greatest index met, with its line: what it names may follow.
struct LargestIndex {
  std::int64_t index = -1, line = 0, element = -1;

  /// Notes a zero-based index and returns it in 32 bits, which a wrong one may not fit.
  std::int32_t note(std::int64_t value, std::int64_t at_line, std::int64_t at_element = -1);
  /// Takes up that of the lines behind, whose lines and elements count from these.
  void join(const LargestIndex& behind, std::int64_t lines_before, std::int64_t elements_before);
};

/// What tags name, and tags that say nothing to the reader.
struct ObjTagNotes {
  LargestIndex largest_vertex, largest_face;
  LineNote unknown;
};

/// The tags `t crease`, `t corner` and `t hole` of OpenSubdiv's shapes, which count from 0:
/// `t name integers/numbers/strings values...`. Throws Error{UnreadableInput}.
class ObjTags {
 public:
  ObjTags(const TextLines& lines, PolygonMesh& mesh, ObjTagNotes& notes)
      : lines_(lines), mesh_(mesh), notes_(notes) {}

  /// The rest of a line behind its `t`.
  void read(Words words);

 private:
  std::array<std::int64_t, 3> read_counts(std::string_view word) const;
  void add_creases(std::span<const std::int32_t> vertices, std::span<const float> values);
  void add_corners(std::span<const std::int32_t> vertices, std::span<const float> values);

  const TextLines& lines_;
  PolygonMesh& mesh_;
  ObjTagNotes& notes_;
};

}  // namespace planish
