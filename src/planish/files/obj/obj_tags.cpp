// Based on: the shapes of OpenSubdiv's regression suite.
#include "planish/files/obj/obj_tags.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "planish/core/formatted.h"
#include "planish/core/number_text.h"

namespace planish {

std::int32_t LargestIndex::note(std::int64_t value, std::int64_t at_line, std::int64_t at_element) {
  if (value > index) *this = {value, at_line, at_element};
  return static_cast<std::int32_t>(
      std::min<std::int64_t>(value, std::numeric_limits<std::int32_t>::max()));
}

void LargestIndex::join(const LargestIndex& behind, std::int64_t lines_before,
                        std::int64_t elements_before) {
  if (behind.index > index)
    *this = {behind.index, behind.line + lines_before, behind.element + elements_before};
}

std::array<std::int64_t, 3> ObjTags::read_counts(std::string_view word) const {
  std::array<std::int64_t, 3> counts{};
  const std::size_t first = word.find('/');
  const std::size_t second = first == std::string_view::npos ? first : word.find('/', first + 1);
  if (second == std::string_view::npos || !parse_integer(word.substr(0, first), counts[0]) ||
      !parse_integer(word.substr(first + 1, second - first - 1), counts[1]) ||
      !parse_integer(word.substr(second + 1), counts[2]) || std::ranges::min(counts) < 0)
    lines_.fail("tag counts " + quote(word) + " are no integers/numbers/strings");
  return counts;
}

void ObjTags::read(Words words) {
  const std::string_view name = words.next();
  const bool is_hole = name == "hole";
  if (name != "crease" && name != "corner" && !is_hole) {
    notes_.unknown.add(lines_.number(), "unknown tag " + quote(name));
    return;
  }
  const auto [integers, numbers, strings] = read_counts(words.next());
  LargestIndex& largest = is_hole ? notes_.largest_face : notes_.largest_vertex;
  std::vector<std::int32_t> indices;
  for (std::int64_t i = 0; i < integers; ++i) {
    const std::string_view word = words.next();
    std::int64_t index = -1;
    if (!parse_integer(word, index) || index < 0)
      lines_.fail(std::string(is_hole ? "tag face " : "tag vertex ") + quote(word) +
                  " is no index from 0");
    indices.push_back(largest.note(index, lines_.number()));
  }
  std::vector<float> values;
  for (std::int64_t i = 0; i < numbers; ++i) {
    const std::string_view word = words.next();
    double value = 0;
    if (!parse_number(word, value) || value < 0)
      lines_.fail("tag sharpness " + quote(word) + " is no number from 0");
    values.push_back(
        static_cast<float>(std::min<double>(value, std::numeric_limits<float>::max())));
  }
  if (is_hole) {
    mesh_.hole_faces.insert(mesh_.hole_faces.end(), indices.begin(), indices.end());
  } else {
    name == "crease" ? add_creases(indices, values) : add_corners(indices, values);
  }
}

void ObjTags::add_creases(std::span<const std::int32_t> vertices, std::span<const float> values) {
  const std::size_t edges = vertices.size() / 2;
  if (vertices.size() % 2 != 0 || (values.size() != 1 && values.size() != edges))
    lines_.fail(
        formatted("crease of {} vertices and {} sharpnesses; pairs of vertices with one sharpness "
                  "each or together are needed",
                  vertices.size(), values.size()));
  for (std::size_t i = 0; i < edges; ++i)
    mesh_.creases.push_back({.v0 = vertices[2 * i],
                             .v1 = vertices[2 * i + 1],
                             .sharpness = values[values.size() == 1 ? 0 : i]});
}

void ObjTags::add_corners(std::span<const std::int32_t> vertices, std::span<const float> values) {
  if (values.size() != 1 && values.size() != vertices.size())
    lines_.fail(formatted(
        "corner tag of {} vertices and {} sharpnesses; one sharpness each or together is needed",
        vertices.size(), values.size()));
  for (std::size_t i = 0; i < vertices.size(); ++i)
    mesh_.corners.push_back(
        {.vertex = vertices[i], .sharpness = values[values.size() == 1 ? 0 : i]});
}

}  // namespace planish
