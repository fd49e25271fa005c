// Based on: Wavefront Technologies, "Object Files (.obj)", Advanced Visualizer manual, appendix B1.
// Numbers are parsed to the last bit, because a cage must be read back bit by bit.
#include "planish/files/obj/obj_part.h"

#include <algorithm>
#include <array>
#include <limits>

#include "planish/core/number_text.h"
#include "planish/files/shared/srgb.h"

namespace planish {
namespace {

constexpr std::array<std::string_view, 5> kDroppedKeywords = {"curv", "curv2", "l", "p", "surf"};
constexpr std::array<std::string_view, 33> kPassedOverKeywords = {
    "bevel", "bmat",       "bsp",   "bzp", "c_interp", "call",     "cdc",  "cdp",  "con",
    "csh",   "cstype",     "ctech", "deg", "d_interp", "end",      "hole", "lod",  "maplib",
    "mg",    "mtllib",     "parm",  "res", "s",        "scrv",     "sp",   "step", "trim",
    "vn",    "shadow_obj", "stech", "vp",  "usemap",   "trace_obj"};

// All words of a line, with one blank between them.
std::string joined(Words words) {
  std::string text(words.next());
  for (std::string_view word = words.next(); !word.empty(); word = words.next())
    text.append(" ").append(word);
  return text;
}

}  // namespace

void ObjPartReader::read() {
  while (lines_.next()) read_line();
  part_.line_count = lines_.lines_passed();
}

void ObjPartReader::name(ObjPart::Naming::What what, Words words) {
  part_.namings.push_back({what, part_.mesh.face_count(), joined(words)});
}

void ObjPartReader::read_line() {
  Words words(lines_.line());
  const std::string_view keyword = words.next();
  if (keyword == "v") {
    read_vertex(words);
  } else if (keyword == "f" || keyword == "fo") {
    read_face(words);
  } else if (keyword == "vt") {
    read_uv(words);
  } else if (keyword == "t") {
    tags_.read(words);
  } else if (keyword == "usemtl") {
    name(ObjPart::Naming::What::Material, words);
  } else if (keyword == "g") {
    name(ObjPart::Naming::What::Group, words);
  } else if (keyword == "o") {
    name(ObjPart::Naming::What::Object, words);
  } else if (keyword.empty()) {
    read_comment();
  } else {
    read_other(keyword);
  }
}

void ObjPartReader::read_comment() {
  constexpr std::string_view kHeader = "# planish ";
  if (lines_.line().starts_with(kHeader)) part_.header.emplace_back(lines_.line().substr(2));
}

// `x y z`, `x y z w`, `x y z r g b` or `x y z r g b a`; w is for curves only.
void ObjPartReader::read_vertex(Words words) {
  const auto vertex = static_cast<std::int64_t>(part_.mesh.positions.size());
  if (vertex == std::numeric_limits<std::int32_t>::max())
    lines_.fail("more than " + std::to_string(vertex) + " vertices");
  glm::dvec3 position(0.0);
  glm::dvec4 color(1.0);
  int count = 0;
  for (std::string_view word = words.next(); !word.empty(); word = words.next(), ++count) {
    double value = 0;
    if (!parse_number(word, value))
      lines_.fail("vertex coordinate " + quote(word) + " is no finite number", vertex);
    if (count < 3) {
      position[count] = value;
    } else if (count < 7) {
      color[count - 3] = value;
    }
  }
  if (count < 3)
    lines_.fail("vertex has " + std::to_string(count) + " coordinates, 3 are needed", vertex);
  part_.mesh.positions.push_back(position);
  if (count < 6) return;
  const auto is_outside = [&](int i) { return color[i] < 0 || color[i] > 1; };
  if (is_outside(0) || is_outside(1) || is_outside(2) || is_outside(3)) ++part_.clamped_colors;
  part_.mesh.colors.resize(part_.mesh.positions.size() - 1, kNoObjColor);
  part_.mesh.colors.push_back(linear_of_srgb(color));
}

// `u`, `u v` or `u v w`; w is for textures in space.
void ObjPartReader::read_uv(Words words) {
  const auto index = static_cast<std::int64_t>(part_.uvs.size());
  if (index == std::numeric_limits<std::int32_t>::max())
    lines_.fail("more than " + std::to_string(index) + " texture coordinates");
  glm::dvec2 uv(0.0);
  int count = 0;
  for (std::string_view word = words.next(); !word.empty(); word = words.next(), ++count) {
    double value = 0;
    if (!parse_number(word, value))
      lines_.fail("texture coordinate " + quote(word) + " is no finite number", index);
    if (count < 2) uv[count] = value;
  }
  if (count == 0) lines_.fail("texture coordinate without a number", index);
  part_.uvs.push_back(uv);
}

// From what a face says: counted from 1, or backwards from the last that stands before it.
std::int32_t ObjPartReader::zero_based(std::int64_t index, const char* what, std::size_t count,
                                       LargestIndex& largest, std::vector<std::size_t>& backward) {
  const std::int64_t face = part_.mesh.face_count();
  const auto before = static_cast<std::int64_t>(count);
  if (index > 0) return largest.note(index - 1, lines_.number(), face);
  if (index == 0)
    lines_.fail(std::string("face names ") + what + " 0, but OBJ counts from 1", face);
  if (is_first_ && index < -before)
    lines_.fail(std::string("face names ") + what + " " + std::to_string(index) + ", but only " +
                    std::to_string(before) + " stand before it",
                face);
  if (before + index < std::numeric_limits<std::int32_t>::min())
    lines_.fail("an index too far back");  // the whole file has better words
  if (!is_first_) backward.push_back(part_.mesh.face_vertices.size());
  return static_cast<std::int32_t>(before + index);
}

// `v`, `v/vt`, `v//vn` or `v/vt/vn`; vn is not used.
void ObjPartReader::read_corner(std::string_view word) {
  std::array<std::int64_t, 3> parts{};
  std::array<bool, 3> given{};
  std::size_t begin = 0;
  bool readable = true;
  for (std::size_t part = 0; readable && begin <= word.size(); ++part) {
    const std::size_t end = std::min(word.find('/', begin), word.size());
    const std::string_view text = word.substr(begin, end - begin);
    readable = part < 3 && (text.empty() || parse_integer(text, parts[part]));
    if (readable) given[part] = !text.empty();
    begin = end + 1;
  }
  if (!readable || !given[0])
    lines_.fail("face corner " + quote(word) + " is no v/vt/vn", part_.mesh.face_count());
  const std::int32_t vertex = zero_based(parts[0], "vertex", part_.mesh.positions.size(),
                                         part_.largest_vertex, part_.backward_vertices);
  if (given[1]) {
    part_.mesh.face_uvs.resize(part_.mesh.face_vertices.size(), -1);
    part_.mesh.face_uvs.push_back(zero_based(parts[1], "texture coordinate", part_.uvs.size(),
                                             part_.largest_uv, part_.backward_uvs));
  }
  part_.mesh.face_vertices.push_back(vertex);
}

void ObjPartReader::read_face(Words words) {
  auto& corners = part_.mesh.face_vertices;
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) read_corner(word);
  if (corners.size() > std::numeric_limits<std::int32_t>::max())
    lines_.fail("more face corners than 32 bits can count", part_.mesh.face_count());
  part_.mesh.face_offsets.push_back(static_cast<std::int32_t>(corners.size()));
}

void ObjPartReader::read_other(std::string_view keyword) {
  if (std::ranges::find(kPassedOverKeywords, keyword) != kPassedOverKeywords.end()) return;
  if (std::ranges::find(kDroppedKeywords, keyword) != kDroppedKeywords.end()) {
    ++part_.dropped_element_count;
    return;
  }
  part_.unknown_keyword.add(keyword, lines_.number());
}

}  // namespace planish
