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
};

/// Lines that say nothing to a reader; the first of them is named.
struct UnknownWord {
  std::int64_t count = 0, line = 0;
  std::string name;

  void add(std::string_view word, std::int64_t at_line);
};

/// The tags `t crease`, `t corner` and `t hole` of OpenSubdiv's shapes, which count from 0:
/// `t name integers/numbers/strings values...`. Throws Error{UnreadableInput}.
class ObjTags {
 public:
  ObjTags(const TextLines& lines, PolygonMesh& mesh) : lines_(lines), mesh_(mesh) {}

  /// The rest of a line behind its `t`.
  void read(Words words);

  [[nodiscard]] const LargestIndex& largest_vertex() const { return largest_vertex_; }
  [[nodiscard]] const LargestIndex& largest_face() const { return largest_face_; }
  [[nodiscard]] const UnknownWord& unknown() const { return unknown_; }

 private:
  std::array<std::int64_t, 3> read_counts(std::string_view word) const;
  void add_creases(std::span<const std::int32_t> vertices, std::span<const float> values);
  void add_corners(std::span<const std::int32_t> vertices, std::span<const float> values);

  const TextLines& lines_;
  PolygonMesh& mesh_;
  LargestIndex largest_vertex_, largest_face_;
  UnknownWord unknown_;
};

}  // namespace planish
