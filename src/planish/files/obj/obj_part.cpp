// Based on: Wavefront Technologies, "Object Files (.obj)", Advanced Visualizer manual, appendix B1.
// Numbers are parsed to the last bit, because a cage must be read back bit by bit.
#include "planish/files/obj/obj_part.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "planish/core/counted.h"
#include "planish/core/formatted.h"
#include "planish/core/number_text.h"
#include "planish/files/shared/srgb.h"

namespace planish {
namespace {

constexpr std::int64_t kMostIndices = std::numeric_limits<std::int32_t>::max();

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

class ObjPartReader {
 public:
  ObjPartReader(const TextLines& lines, const ObjCounts* before)
      : lines_(lines), tags_(lines_, part_.mesh, part_.tags) {
    if (before == nullptr) return;
    part_.is_settled = true;
    before_ = *before;
    lines_.count_from(before_.line);
  }

  ObjPartReader(const ObjPartReader&) = delete;
  ObjPartReader& operator=(const ObjPartReader&) = delete;

  ObjPart read();

 private:
  // A kind of index that corners have.
  struct Indices {
    const char* what;
    std::int64_t before;  // as many stand before the line
    LargestIndex& largest;
    ObjBackward& backward;
    LineNote* missing;  // null: an index that names nothing is an error
  };

  [[nodiscard]] std::int64_t vertex() const { return before_.vertex + part_.mesh.vertex_count(); }
  [[nodiscard]] std::int64_t face() const { return before_.face + part_.mesh.face_count(); }

  void read_line();
  void read_comment();
  void read_vertex(Words words);
  void read_uv(Words words);
  void read_face(Words words);
  void read_corner(std::string_view word);
  std::int32_t zero_based(std::int64_t index, const Indices& indices);
  void read_other(std::string_view keyword);
  void name(ObjPart::Naming::What what, Words words);

  TextLines lines_;
  ObjPart part_;
  ObjTags tags_;
  ObjCounts before_;
};

ObjPart ObjPartReader::read() {
  while (lines_.next()) read_line();
  part_.line_count = lines_.lines_passed() - before_.line;
  return std::move(part_);
}

void ObjPartReader::name(ObjPart::Naming::What what, Words words) {
  part_.namings.push_back({what, part_.mesh.face_count(), joined(words)});
  if (lines_.line().find_first_of("\r\n") == std::string_view::npos) return;
  const std::string_view keyword = Words(lines_.line()).next();
  part_.notes.continued_names.add(lines_.number(), quote(keyword) +
                                                       " ends with `\\` and goes on with "
                                                       "the next line, which is part of the name " +
                                                       quote(part_.namings.back().name));
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
  if (vertex() >= kMostIndices) lines_.fail("more than " + counted(kMostIndices, "vertex"));
  glm::dvec3 position(0.0);
  glm::dvec4 color(1.0);
  int count = 0;
  bool is_bad = false;
  for (std::string_view word = words.next(); !word.empty(); word = words.next(), ++count) {
    double value = 0;
    if (!parse_number(word, value)) {
      const std::string what = "vertex coordinate " + no_finite_number(word);
      if (!is_non_finite_word(word)) lines_.fail(what, vertex());
      LineNote& note = count < 3 ? part_.notes.bad_positions : part_.notes.bad_colors;
      if (!is_bad) lines_.note(note, what, vertex());
      is_bad = true;
      value = std::numeric_limits<double>::quiet_NaN();
    }
    if (count < 3) {
      position[count] = value;
    } else if (count < 7) {
      color[count - 3] = value;
    }
  }
  if (count < 3) lines_.fail(formatted("vertex has {} coordinates, 3 are needed", count), vertex());
  part_.mesh.positions.push_back(position);
  if (count < 6 || is_bad) return;
  const auto is_outside = [&](int i) { return color[i] < 0 || color[i] > 1; };
  if (is_outside(0) || is_outside(1) || is_outside(2) || is_outside(3))
    ++part_.notes.clamped_colors;
  part_.mesh.colors.resize(part_.mesh.positions.size() - 1, kNoObjColor);
  part_.mesh.colors.push_back(linear_of_srgb(color));
}

// `u`, `u v` or `u v w`; w is for textures in space.
void ObjPartReader::read_uv(Words words) {
  const std::int64_t index = before_.uv + std::ssize(part_.uvs);
  if (index >= kMostIndices)
    lines_.fail(formatted("more than {} texture coordinates", kMostIndices));
  glm::dvec2 uv(0.0);
  int count = 0;
  bool is_bad = false;
  for (std::string_view word = words.next(); !word.empty(); word = words.next(), ++count) {
    double value = 0;
    if (!parse_number(word, value)) {
      const std::string what = "texture coordinate " + no_finite_number(word);
      if (!is_non_finite_word(word)) lines_.fail(what, index);
      if (!is_bad) lines_.note(part_.notes.bad_uvs, what, index);
      is_bad = true;
    }
    if (count < 2) uv[count] = value;
  }
  if (count == 0) lines_.fail("texture coordinate without a number", index);
  part_.uvs.push_back(is_bad ? glm::dvec2(std::numeric_limits<double>::quiet_NaN()) : uv);
}

// From what a face says: counted from 1, or backwards from the last that stands before it.
std::int32_t ObjPartReader::zero_based(std::int64_t index, const Indices& indices) {
  if (index > 0) return indices.largest.note(index - 1, lines_.number(), face());
  const auto fault = [&](const std::string& what) {
    if (indices.missing == nullptr) lines_.fail(what, face());
    lines_.note(*indices.missing, what, face());
    return -1;
  };
  const std::string named = std::string("face names ") + indices.what + " ";
  if (index == 0) return fault(named + "0, but OBJ counts from 1");
  const std::int64_t place = indices.before + index;
  if (part_.is_settled) {
    if (place >= 0) return static_cast<std::int32_t>(place);
    return fault(formatted("{}{}, but only {} stand before it", named, index, indices.before));
  }
  indices.backward.corners.push_back(part_.mesh.face_vertices.size());
  indices.backward.lowest = std::min(indices.backward.lowest, place);
  // One that does not fit lies before any file.
  return static_cast<std::int32_t>(
      std::max<std::int64_t>(place, std::numeric_limits<std::int32_t>::min()));
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
  if (!readable || !given[0]) lines_.fail("face corner " + quote(word) + " is no v/vt/vn", face());
  const std::int32_t named = zero_based(
      parts[0], {"vertex", vertex(), part_.largest_vertex, part_.backward_vertices, nullptr});
  if (given[1]) {
    part_.mesh.face_uvs.resize(part_.mesh.face_vertices.size(), -1);
    part_.mesh.face_uvs.push_back(
        zero_based(parts[1], {"texture coordinate", before_.uv + std::ssize(part_.uvs),
                              part_.largest_uv, part_.backward_uvs, &part_.notes.missing_uvs}));
  }
  part_.mesh.face_vertices.push_back(named);
}

void ObjPartReader::read_face(Words words) {
  auto& corners = part_.mesh.face_vertices;
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) read_corner(word);
  if (before_.corner + std::ssize(corners) > kMostIndices)
    lines_.fail("more face corners than 32 bits can count", face());
  part_.mesh.face_offsets.push_back(static_cast<std::int32_t>(corners.size()));
}

void ObjPartReader::read_other(std::string_view keyword) {
  if (std::ranges::find(kPassedOverKeywords, keyword) != kPassedOverKeywords.end()) return;
  if (std::ranges::find(kDroppedKeywords, keyword) != kDroppedKeywords.end()) {
    ++part_.dropped_element_count;
    return;
  }
  part_.notes.unknown_keyword.add(lines_.number(), "unknown keyword " + quote(keyword));
}

}  // namespace

ObjCounts ObjPart::counts() const {
  return {line_count, mesh.vertex_count(), std::ssize(uvs), mesh.face_count(),
          std::ssize(mesh.face_vertices)};
}

ObjPart read_obj_part(const TextLines& lines, const ObjCounts* before) {
  return ObjPartReader(lines, before).read();
}

}  // namespace planish
