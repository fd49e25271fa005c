// The lines once more, since few want normals: read_obj() need not pay for them.
#include "planish/files/obj/obj_normals.h"

#include <cstdint>
#include <string>

#include "planish/core/formatted.h"
#include "planish/core/number_text.h"
#include "planish/files/obj/obj_tags.h"
#include "planish/files/shared/text_lines.h"

namespace planish {
namespace {

glm::vec3 normal_of(Words words) {
  glm::dvec3 normal(0.0);
  for (int axis = 0; axis < 3; ++axis)
    if (!parse_number(words.next(), normal[axis])) return glm::vec3(0.0f);
  return normal;
}

// What stands behind the second slash; 0 for none.
std::int64_t normal_index(std::string_view corner) {
  const std::size_t first = corner.find('/');
  if (first == std::string_view::npos) return 0;
  const std::size_t second = corner.find('/', first + 1);
  std::int64_t index = 0;
  if (second == std::string_view::npos || !parse_integer(corner.substr(second + 1), index))
    return 0;
  return index;
}

}  // namespace

CornerNormals read_obj_normals(const FileBytes& file, LineNote& missing) {
  const TextLines whole(file, TextLines::Continuation::Backslash);
  CornerNormals normals;
  LargestIndex largest;
  std::int64_t face = 0;
  const auto read_line = [&](const TextLines& lines) {
    Words words(lines.line());
    const std::string_view keyword = words.next();
    if (keyword == "vn") normals.values.push_back(normal_of(words));
    if (keyword != "f" && keyword != "fo") return;
    for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
      const auto before = static_cast<std::int64_t>(normals.values.size());
      const std::int64_t index = normal_index(word);
      std::int32_t normal = -1;
      if (index > 0) {
        normal = largest.note(index - 1, lines.number(), face);
      } else if (index < -before) {
        lines.note(missing,
                   formatted("face names normal {}, but only {} stand before it", index, before),
                   face);
      } else if (index < 0) {
        normal = static_cast<std::int32_t>(before + index);
      }
      normals.of_corners.push_back(normal);
    }
    ++face;
  };
  std::int64_t passed = 0;
  for (TextLines& part : whole.cut(kTextPartBytes)) {
    part.count_from(passed);
    while (part.next()) read_line(part);
    passed = part.lines_passed();
    part.count();
  }
  const auto count = static_cast<std::int64_t>(normals.values.size());
  if (largest.index < count) return normals;
  whole.note_at(missing, largest.line,
                formatted("face names normal {} of {}", largest.index + 1, count), largest.element);
  --missing.count;
  for (std::int32_t& normal : normals.of_corners) {
    if (normal < count) continue;
    normal = -1;
    ++missing.count;
  }
  return normals;
}

}  // namespace planish
