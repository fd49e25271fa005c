// Based on: Wavefront Technologies, "Object Files (.obj)", Advanced Visualizer manual, appendix B1.
// Numbers are parsed with std::from_chars, because a cage must be read back bit by bit.
#include "planish/files/obj/read_obj.h"

#include <algorithm>
#include <array>
#include <limits>

#include "planish/files/obj/obj_tags.h"
#include "planish/files/shared/attribute_collector.h"
#include "planish/files/shared/srgb.h"
#include "planish/files/shared/text_lines.h"

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

class ObjReader {
 public:
  ObjReader(std::span<const std::byte> bytes, std::string_view name)
      : lines_(bytes, name, TextLines::Continuation::Backslash), tags_(lines_, file_.mesh) {}

  MeshFile read() {
    file_.format = FileFormat::Obj;
    while (lines_.next()) read_line();
    warn_of(unknown_keyword_, "keyword");
    warn_of(tags_.unknown(), "tag");
    warn_of_clamped_colors();
    const auto vertex_count = static_cast<std::int64_t>(file_.mesh.positions.size());
    // Faces count from 1, tags from 0.
    require(largest_vertex_, 1, "face names vertex ", vertex_count);
    require(largest_uv_, 1, "face names texture coordinate ",
            static_cast<std::int64_t>(uvs_.size()));
    require(tags_.largest_vertex(), 0, "tag names vertex ", vertex_count);
    require(tags_.largest_face(), 0, "tag names face ", file_.mesh.face_count());
    attributes_.finish(std::move(uvs_), file_.mesh);
    return std::move(file_);
  }

 private:
  void read_line();
  void read_comment();
  void read_vertex(Words words);
  void read_uv(Words words);
  void read_face(Words words);
  void read_corner(std::string_view word);
  std::int32_t zero_based(std::int64_t index, const std::string& what, std::size_t count,
                          LargestIndex& largest);
  void use_group();
  void read_other(std::string_view keyword);
  void warn_of(const UnknownWord& unknown, const std::string& kind);
  void warn_of_clamped_colors();
  void require(const LargestIndex& largest, int base, const std::string& what,
               std::int64_t count) const;

  TextLines lines_;
  MeshFile file_;
  ObjTags tags_;
  AttributeCollector attributes_;
  std::vector<glm::dvec2> uvs_;
  std::string object_, group_, material_;
  LargestIndex largest_vertex_, largest_uv_;
  UnknownWord unknown_keyword_;
  std::int64_t clamped_colors_ = 0;
};

void ObjReader::read_line() {
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
    material_ = joined(words);
    use_group();
  } else if (keyword == "g") {
    group_ = joined(words);
    use_group();
  } else if (keyword == "o") {
    object_ = joined(words);
    group_.clear();
    use_group();
  } else if (keyword.empty()) {
    read_comment();
  } else {
    read_other(keyword);
  }
}

void ObjReader::read_comment() {
  constexpr std::string_view kHeader = "# planish ";
  if (lines_.line().starts_with(kHeader)) file_.header.emplace_back(lines_.line().substr(2));
}

void ObjReader::use_group() {
  attributes_.use_group({.name = group_.empty() ? object_ : group_, .material = material_});
}

// `x y z`, `x y z w`, `x y z r g b` or `x y z r g b a`; w is for curves only.
void ObjReader::read_vertex(Words words) {
  const auto vertex = static_cast<std::int64_t>(file_.mesh.positions.size());
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
  file_.mesh.positions.push_back(position);
  if (count < 6) return;
  const auto is_outside = [&](int i) { return color[i] < 0 || color[i] > 1; };
  if (is_outside(0) || is_outside(1) || is_outside(2) || is_outside(3)) ++clamped_colors_;
  attributes_.color_vertex(static_cast<std::int32_t>(vertex), linear_of_srgb(color));
}

// `u`, `u v` or `u v w`; w is for textures in space.
void ObjReader::read_uv(Words words) {
  const auto index = static_cast<std::int64_t>(uvs_.size());
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
  uvs_.push_back(uv);
}

// From what a face says: counted from 1, or backwards from the last that stands before it.
std::int32_t ObjReader::zero_based(std::int64_t index, const std::string& what, std::size_t count,
                                   LargestIndex& largest) {
  const std::int64_t face = file_.mesh.face_count();
  const auto before = static_cast<std::int64_t>(count);
  if (index == 0) lines_.fail("face names " + what + " 0, but OBJ counts from 1", face);
  if (index < -before)
    lines_.fail("face names " + what + " " + std::to_string(index) + ", but only " +
                    std::to_string(before) + " stand before it",
                face);
  return largest.note(index > 0 ? index - 1 : before + index, lines_.number(), face);
}

// `v`, `v/vt`, `v//vn` or `v/vt/vn`; vn is not used.
void ObjReader::read_corner(std::string_view word) {
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
    lines_.fail("face corner " + quote(word) + " is no v/vt/vn", file_.mesh.face_count());
  file_.mesh.face_vertices.push_back(
      zero_based(parts[0], "vertex", file_.mesh.positions.size(), largest_vertex_));
  attributes_.add_corner(
      given[1] ? zero_based(parts[1], "texture coordinate", uvs_.size(), largest_uv_) : -1);
}

void ObjReader::read_face(Words words) {
  auto& corners = file_.mesh.face_vertices;
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) read_corner(word);
  if (corners.size() > std::numeric_limits<std::int32_t>::max())
    lines_.fail("more face corners than 32 bits can count", file_.mesh.face_count());
  file_.mesh.face_offsets.push_back(static_cast<std::int32_t>(corners.size()));
  attributes_.add_face();
}

void ObjReader::read_other(std::string_view keyword) {
  if (std::ranges::find(kPassedOverKeywords, keyword) != kPassedOverKeywords.end()) return;
  if (std::ranges::find(kDroppedKeywords, keyword) != kDroppedKeywords.end()) {
    ++file_.dropped_element_count;
    return;
  }
  unknown_keyword_.add(keyword, lines_.number());
}

void ObjReader::warn_of(const UnknownWord& unknown, const std::string& kind) {
  if (unknown.count == 0) return;
  const std::string what = "unknown " + kind + " " + unknown.name;
  if (file_.mesh.positions.empty())
    lines_.fail_at(unknown.line, what + " in a file without vertices: this is no OBJ file");
  file_.warnings.push_back(
      {.code = "unknown-" + kind,
       .message = "line " + std::to_string(unknown.line) + ": " + what + "; such lines are ignored",
       .count = unknown.count});
}

void ObjReader::warn_of_clamped_colors() {
  if (clamped_colors_ == 0) return;
  file_.warnings.push_back({.code = "clamped-colors",
                            .message = std::to_string(clamped_colors_) +
                                       " vertex colours lie outside 0 to 1 and are clamped",
                            .count = clamped_colors_});
}

void ObjReader::require(const LargestIndex& largest, int base, const std::string& what,
                        std::int64_t count) const {
  if (largest.index < count) return;
  lines_.fail_at(largest.line,
                 what + std::to_string(largest.index + base) + " of " + std::to_string(count),
                 largest.element);
}

}  // namespace

MeshFile read_obj(std::span<const std::byte> bytes, std::string_view name) {
  return ObjReader(bytes, name).read();
}

}  // namespace planish
