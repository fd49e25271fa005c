// Based on: Wavefront Technologies, "Object Files (.obj)", Advanced Visualizer manual, appendix B1;
// tags as in the shapes of OpenSubdiv's regression suite: `t crease 2/1/0 v0 v1 sharpness`.
// Numbers are parsed with std::from_chars, because a cage must be read back bit by bit.
#include "planish/mesh/read_obj.h"

#include <algorithm>
#include <array>
#include <limits>

#include "planish/mesh/text_lines.h"

namespace planish {
namespace {

constexpr std::array<std::string_view, 5> kDroppedKeywords = {"curv", "curv2", "l", "p", "surf"};
constexpr std::array<std::string_view, 37> kPassedOverKeywords = {
    "bevel",  "bmat",      "bsp",    "bzp",        "c_interp", "call", "cdc",  "cdp",
    "con",    "csh",       "cstype", "ctech",      "d_interp", "deg",  "end",  "g",
    "hole",   "lod",       "maplib", "mg",         "mtllib",   "o",    "parm", "res",
    "s",      "scrv",      "sp",     "shadow_obj", "stech",    "step", "trim", "usemap",
    "usemtl", "trace_obj", "vn",     "vp",         "vt"};

class ObjReader {
 public:
  ObjReader(std::span<const std::byte> bytes, std::string_view name)
      : lines_(bytes, name, TextLines::Continuation::Backslash) {}

  MeshFile read() {
    file_.format = MeshFormat::Obj;
    while (lines_.next()) read_line();
    warn_of(unknown_keyword_, "keyword");
    warn_of(unknown_tag_, "tag");
    require_vertex(largest_in_face_, "face");
    require_vertex(largest_in_tag_, "tag");
    return std::move(file_);
  }

 private:
  // The greatest vertex index met, with its line: vertices may follow the faces that name them.
  struct Largest {
    std::int64_t vertex = -1, line = 0, element = -1;
  };
  // Lines that say nothing to this reader; the first of them is named.
  struct Unknown {
    std::int64_t count = 0, line = 0;
    std::string name;

    void add(std::string_view word, std::int64_t number) {
      if (count++ > 0) return;
      line = number;
      name = quote(word);
    }
  };

  void read_line();
  void read_comment();
  void read_vertex(Words words);
  void read_face(Words words);
  std::int32_t read_corner(std::string_view word);
  void read_tag(Words words);
  std::array<std::int64_t, 3> read_tag_counts(std::string_view word);
  void read_crease(std::span<const std::int32_t> vertices, std::span<const float> values);
  void read_corner_tag(std::span<const std::int32_t> vertices, std::span<const float> values);
  void read_other(std::string_view keyword);
  void warn_of(const Unknown& unknown, const std::string& kind);
  void require_vertex(const Largest& largest, const std::string& what) const;

  TextLines lines_;
  MeshFile file_;
  Largest largest_in_face_, largest_in_tag_;
  Unknown unknown_keyword_, unknown_tag_;
};

void ObjReader::read_line() {
  Words words(lines_.line());
  const std::string_view keyword = words.next();
  if (keyword == "v") {
    read_vertex(words);
  } else if (keyword == "f" || keyword == "fo") {
    read_face(words);
  } else if (keyword == "t") {
    read_tag(words);
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

void ObjReader::read_vertex(Words words) {
  const auto vertex = static_cast<std::int64_t>(file_.mesh.positions.size());
  if (vertex == std::numeric_limits<std::int32_t>::max())
    lines_.fail("more than " + std::to_string(vertex) + " vertices");
  glm::dvec3 position(0.0);
  int count = 0;
  // Weights and colours may follow; they carry nothing that is used here.
  for (std::string_view word = words.next(); !word.empty(); word = words.next(), ++count) {
    double value = 0;
    if (!parse_number(word, value))
      lines_.fail("vertex coordinate " + quote(word) + " is no finite number", vertex);
    if (count < 3) position[count] = value;
  }
  if (count < 3)
    lines_.fail("vertex has " + std::to_string(count) + " coordinates, 3 are needed", vertex);
  file_.mesh.positions.push_back(position);
}

// `v`, `v/vt`, `v//vn` or `v/vt/vn`; only v is used.
std::int32_t ObjReader::read_corner(std::string_view word) {
  const std::size_t slash = word.find('/');
  std::int64_t index = 0;
  bool readable = parse_integer(word.substr(0, slash), index);
  int part = 0;
  for (std::size_t at = slash; readable && at != std::string_view::npos; ++part) {
    const std::size_t next = word.find('/', at + 1);
    const std::string_view text = word.substr(at + 1, next - at - 1);
    std::int64_t ignored = 0;
    readable = part < 2 && (text.empty() || parse_integer(text, ignored));
    at = next;
  }
  const std::int64_t face = file_.mesh.face_count();
  if (!readable) lines_.fail("face corner " + quote(word) + " is no v/vt/vn", face);
  const auto count = static_cast<std::int64_t>(file_.mesh.positions.size());
  if (index == 0) lines_.fail("face names vertex 0, but OBJ counts from 1", face);
  if (index < -count)
    lines_.fail("face names vertex " + std::to_string(index) + ", but only " +
                    std::to_string(count) + " stand before it",
                face);
  const std::int64_t vertex = index > 0 ? index - 1 : count + index;
  if (vertex > largest_in_face_.vertex) largest_in_face_ = {vertex, lines_.number(), face};
  return static_cast<std::int32_t>(
      std::min<std::int64_t>(vertex, std::numeric_limits<std::int32_t>::max()));
}

void ObjReader::read_face(Words words) {
  auto& corners = file_.mesh.face_vertices;
  for (std::string_view word = words.next(); !word.empty(); word = words.next())
    corners.push_back(read_corner(word));
  if (corners.size() > std::numeric_limits<std::int32_t>::max())
    lines_.fail("more face corners than 32 bits can count", file_.mesh.face_count());
  file_.mesh.face_offsets.push_back(static_cast<std::int32_t>(corners.size()));
}

std::array<std::int64_t, 3> ObjReader::read_tag_counts(std::string_view word) {
  std::array<std::int64_t, 3> counts{};
  const std::size_t first = word.find('/');
  const std::size_t second = first == std::string_view::npos ? first : word.find('/', first + 1);
  if (second == std::string_view::npos || !parse_integer(word.substr(0, first), counts[0]) ||
      !parse_integer(word.substr(first + 1, second - first - 1), counts[1]) ||
      !parse_integer(word.substr(second + 1), counts[2]) || std::ranges::min(counts) < 0)
    lines_.fail("tag counts " + quote(word) + " are no integers/numbers/strings");
  return counts;
}

// `t name integers/numbers/strings values...`; vertex indices count from 0.
void ObjReader::read_tag(Words words) {
  const std::string_view name = words.next();
  if (name != "crease" && name != "corner") {
    unknown_tag_.add(name, lines_.number());
    return;
  }
  const auto [integers, numbers, strings] = read_tag_counts(words.next());
  std::vector<std::int32_t> vertices;
  for (std::int64_t i = 0; i < integers; ++i) {
    const std::string_view word = words.next();
    std::int64_t index = -1;
    if (!parse_integer(word, index) || index < 0)
      lines_.fail("tag vertex " + quote(word) + " is no index from 0");
    if (index > largest_in_tag_.vertex) largest_in_tag_ = {index, lines_.number(), -1};
    vertices.push_back(static_cast<std::int32_t>(
        std::min<std::int64_t>(index, std::numeric_limits<std::int32_t>::max())));
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
  name == "crease" ? read_crease(vertices, values) : read_corner_tag(vertices, values);
}

void ObjReader::read_crease(std::span<const std::int32_t> vertices, std::span<const float> values) {
  const std::size_t edges = vertices.size() / 2;
  if (vertices.size() % 2 != 0 || (values.size() != 1 && values.size() != edges))
    lines_.fail("crease of " + std::to_string(vertices.size()) + " vertices and " +
                std::to_string(values.size()) +
                " sharpnesses; pairs of vertices with one sharpness each or together are needed");
  for (std::size_t i = 0; i < edges; ++i)
    file_.mesh.creases.push_back({.v0 = vertices[2 * i],
                                  .v1 = vertices[2 * i + 1],
                                  .sharpness = values[values.size() == 1 ? 0 : i]});
}

void ObjReader::read_corner_tag(std::span<const std::int32_t> vertices,
                                std::span<const float> values) {
  if (values.size() != 1 && values.size() != vertices.size())
    lines_.fail("corner tag of " + std::to_string(vertices.size()) + " vertices and " +
                std::to_string(values.size()) +
                " sharpnesses; one sharpness each or together is needed");
  for (std::size_t i = 0; i < vertices.size(); ++i)
    file_.mesh.corners.push_back(
        {.vertex = vertices[i], .sharpness = values[values.size() == 1 ? 0 : i]});
}

void ObjReader::read_other(std::string_view keyword) {
  if (std::ranges::find(kPassedOverKeywords, keyword) != kPassedOverKeywords.end()) return;
  if (keyword == "surf" || std::ranges::find(kDroppedKeywords, keyword) != kDroppedKeywords.end()) {
    ++file_.dropped_element_count;
    return;
  }
  unknown_keyword_.add(keyword, lines_.number());
}

void ObjReader::warn_of(const Unknown& unknown, const std::string& kind) {
  if (unknown.count == 0) return;
  const std::string what = "unknown " + kind + " " + unknown.name;
  if (file_.mesh.positions.empty())
    lines_.fail_at(unknown.line, what + " in a file without vertices: this is no OBJ file");
  file_.warnings.push_back(
      {.code = "unknown-" + kind,
       .message = "line " + std::to_string(unknown.line) + ": " + what + "; such lines are ignored",
       .count = unknown.count});
}

void ObjReader::require_vertex(const Largest& largest, const std::string& what) const {
  const auto count = static_cast<std::int64_t>(file_.mesh.positions.size());
  if (largest.vertex < count) return;
  // Faces count vertices from 1, tags from 0.
  const std::int64_t as_written = largest.vertex + (what == "face");
  lines_.fail_at(
      largest.line,
      what + " names vertex " + std::to_string(as_written) + " of " + std::to_string(count),
      largest.element);
}

}  // namespace

MeshFile read_obj(std::span<const std::byte> bytes, std::string_view name) {
  return ObjReader(bytes, name).read();
}

}  // namespace planish
