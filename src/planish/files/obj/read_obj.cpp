#include "planish/files/obj/read_obj.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/core/words.h"
#include "planish/files/read_file.h"
#include "planish/files/shared/attributes.h"
#include "planish/files/shared/text_lines.h"
#include "planish/files/shared/weld.h"

namespace planish {

// Based on: the shapes of OpenSubdiv's regression suite.

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

namespace {

// Based on: Wavefront Technologies, "Object Files (.obj)", Advanced Visualizer manual, appendix B1.
// Numbers are parsed to the last bit, because a cage must be read back bit by bit.

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

namespace {

ObjCounts operator+(const ObjCounts& a, const ObjCounts& b) {
  return {a.line + b.line, a.vertex + b.vertex, a.uv + b.uv, a.face + b.face, a.corner + b.corner};
}

bool is_too_large(const ObjCounts& counts) {
  return std::max({counts.vertex, counts.uv, counts.corner}) >
         std::numeric_limits<std::int32_t>::max();
}

constexpr const char* kNamesUv = "face names texture coordinate ";

std::string fault_of(const LargestIndex& largest, int base, const char* what, std::int64_t count) {
  return formatted("{}{} of {}", what, largest.index + base, count);
}

void require(const LargestIndex& largest, int base, const char* what, std::int64_t count,
             const TextLines& lines) {
  if (largest.index >= count)
    lines.fail_at(largest.line, fault_of(largest, base, what, count), largest.element);
}

}  // namespace

ObjParts::ObjParts(std::size_t count, LinesOf lines_of, bool is_start)
    : lines_of_(std::move(lines_of)), parts_(count) {
  const ObjCounts none;
  parallel_each(count, 1, [&](std::size_t p) {
    const ObjCounts* before = p == 0 && is_start ? &none : nullptr;
    failure_.watch(p, [&] {
      lines_of_(p, [&](const TextLines& lines) {
        parts_[p] = read_obj_part(lines, before);
        lines.count();
      });
    });
  });
}

ObjCounts ObjParts::counts() const {
  ObjCounts all;
  for (std::size_t p = 0; p < std::min(parts_.size(), failure_.part()); ++p)
    all = all + parts_[p].counts();
  return all;
}

void ObjParts::read_again(std::size_t part, const ObjCounts& before) {
  lines_of_(part, [&](const TextLines& lines) { parts_[part] = read_obj_part(lines, &before); });
}

ObjPart ObjParts::join(const ObjCounts& before) {
  std::vector<ObjCounts> bases{before};
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    const ObjPart& part = parts_[p];
    if (p == failure_.part() || part.backward_vertices.lowest < -bases[p].vertex ||
        part.backward_uvs.lowest < -bases[p].uv || is_too_large(bases[p] + part.counts()))
      read_again(p, bases[p]);
    bases.push_back(bases[p] + parts_[p].counts());
  }
  settle(bases);
  ObjPart all;
  gather_notes(bases, all);
  gather(bases, all);
  return all;
}

void ObjParts::settle(const std::vector<ObjCounts>& before) {
  parallel_each(parts_.size(), 1, [&](std::size_t p) {
    PolygonMesh& mesh = parts_[p].mesh;
    for (const std::size_t corner : parts_[p].backward_vertices.corners)
      mesh.face_vertices[corner] += static_cast<std::int32_t>(before[p].vertex);
    for (const std::size_t corner : parts_[p].backward_uvs.corners)
      mesh.face_uvs[corner] += static_cast<std::int32_t>(before[p].uv);
    for (std::int32_t& offset : mesh.face_offsets)
      offset += static_cast<std::int32_t>(before[p].corner - before[0].corner);
    for (ObjPart::Naming& naming : parts_[p].namings)
      naming.faces_before += before[p].face - before[0].face;
  });
}

void ObjParts::gather_notes(const std::vector<ObjCounts>& before, ObjPart& all) const {
  const auto append = [](auto& to, const auto& values) {
    to.insert(to.end(), values.begin(), values.end());
  };
  PolygonMesh& mesh = all.mesh;
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    const ObjPart& part = parts_[p];
    const ObjCounts base = part.is_settled ? ObjCounts() : before[p];
    append(all.header, part.header);
    append(all.namings, part.namings);
    append(mesh.creases, part.mesh.creases);
    append(mesh.corners, part.mesh.corners);
    append(mesh.hole_faces, part.mesh.hole_faces);
    all.dropped_element_count += part.dropped_element_count;
    all.line_count += part.line_count;
    all.largest_vertex.join(part.largest_vertex, base.line, base.face);
    all.largest_uv.join(part.largest_uv, base.line, base.face);
    all.tags.largest_vertex.join(part.tags.largest_vertex, base.line, 0);
    all.tags.largest_face.join(part.tags.largest_face, base.line, 0);
    all.tags.unknown.join(part.tags.unknown, base.line, 0);
    all.notes.unknown_keyword.join(part.notes.unknown_keyword, base.line, 0);
    all.notes.bad_colors.join(part.notes.bad_colors, base.line, base.vertex);
    all.notes.bad_uvs.join(part.notes.bad_uvs, base.line, base.uv);
    all.notes.missing_uvs.join(part.notes.missing_uvs, base.line, base.face);
    all.notes.continued_names.join(part.notes.continued_names, base.line, 0);
    all.notes.bad_positions.join(part.notes.bad_positions, base.line, base.vertex);
    all.notes.clamped_colors += part.notes.clamped_colors;
  }
}

// The values themselves, each kind by a thread.
void ObjParts::gather(const std::vector<ObjCounts>& before, ObjPart& all) {
  PolygonMesh& mesh = all.mesh;
  const auto total = [&](std::int64_t ObjCounts::*count) {
    return static_cast<std::size_t>(before.back().*count - before.front().*count);
  };
  const auto append = [&](auto& to, auto& values, std::size_t size) {
    if (to.empty()) {
      to = std::move(values);
    } else {
      to.reserve(size);  // here, where GCC 14 sees that insert() has room
      to.insert(to.end(), values.begin(), values.end());
    }
    values = {};
  };
  const auto join_all = [&](auto& to, const auto& values_of, std::int64_t ObjCounts::*count) {
    for (ObjPart& part : parts_) append(to, values_of(part), total(count));
  };
  // What a part has fewer of than its vertices or corners is filled up.
  const auto join_filled = [&](auto& to, auto member, const auto& filler,
                               std::int64_t ObjCounts::*count) {
    const bool any =
        std::ranges::any_of(parts_, [&](ObjPart& part) { return !(part.mesh.*member).empty(); });
    if (!any) return;
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      append(to, parts_[p].mesh.*member, total(count));
      to.resize(static_cast<std::size_t>(before[p + 1].*count - before.front().*count), filler);
    }
  };
  const std::array<std::function<void()>, 6> tasks = {
      [&] {
        join_all(
            mesh.positions, [](ObjPart & p) -> auto& { return p.mesh.positions; },
            &ObjCounts::vertex);
      },
      [&] {
        join_all(
            mesh.face_vertices, [](ObjPart & p) -> auto& { return p.mesh.face_vertices; },
            &ObjCounts::corner);
      },
      [&] {
        mesh.face_offsets = std::move(parts_.front().mesh.face_offsets);
        mesh.face_offsets.reserve(total(&ObjCounts::face) + 1);
        for (std::size_t p = 1; p < parts_.size(); ++p) {
          const std::vector<std::int32_t>& offsets = parts_[p].mesh.face_offsets;
          mesh.face_offsets.insert(mesh.face_offsets.end(), offsets.begin() + 1, offsets.end());
        }
      },
      [&] { join_filled(mesh.face_uvs, &PolygonMesh::face_uvs, -1, &ObjCounts::corner); },
      [&] { join_filled(mesh.colors, &PolygonMesh::colors, kNoObjColor, &ObjCounts::vertex); },
      [&] {
        join_all(
            all.uvs, [](ObjPart & p) -> auto& { return p.uvs; }, &ObjCounts::uv);
      }};
  parallel_each(tasks.size(), 1, [&](std::size_t i) { tasks[i](); });
}

void require_obj(ObjPart& part, const ObjCounts& all, const TextLines& lines) {
  for (const LineNote* unknown : {&part.notes.unknown_keyword, &part.tags.unknown})
    if (unknown->count > 0 && all.vertex == 0)
      lines.fail_at(unknown->line,
                    unknown->what + " in a file without vertices: this is no OBJ file");
  if (const LineNote& bad = part.notes.bad_positions; bad.count > 0)
    lines.fail_at(bad.line, bad.what, bad.element);
  // Faces count from 1, tags from 0.
  require(part.largest_vertex, 1, "face names vertex ", all.vertex, lines);
  if (const LargestIndex& uv = part.largest_uv; uv.index >= all.uv)
    lines.note_at(part.notes.missing_uvs, uv.line, fault_of(uv, 1, kNamesUv, all.uv), uv.element);
  require(part.tags.largest_vertex, 0, "tag names vertex ", all.vertex, lines);
  require(part.tags.largest_face, 0, "tag names face ", all.face, lines);
}

void warn_of(const ObjPart& part, std::string_view name, std::vector<Warning>& warnings) {
  const auto warn_of_unknown = [&](const char* code, const LineNote& unknown) {
    if (unknown.count > 0)
      warnings.push_back(
          {.code = code,
           .message = formatted("line {}: {}; such lines are ignored", unknown.line, unknown.what),
           .count = unknown.count});
  };
  warn_of_unknown("unknown-keyword", part.notes.unknown_keyword);
  warn_of_unknown("unknown-tag", part.tags.unknown);
  if (const std::int64_t count = part.notes.clamped_colors; count > 0)
    warnings.push_back({.code = "clamped-colors",
                        .message = counted(count, "vertex colour") +
                                   (count == 1 ? " lies outside 0 to 1 and is clamped"
                                               : " lie outside 0 to 1 and are clamped"),
                        .count = count});
  part.notes.bad_colors.warn(warnings, "missing-colors", name, "such vertices have no colour");
  part.notes.continued_names.warn(warnings, "continued-names", name,
                                  "a name without `\\` at its end keeps them apart");
  part.notes.bad_uvs.warn(warnings, "missing-texture-coordinates", name,
                          "corners that name such have none");
  part.notes.missing_uvs.warn(warnings, "missing-texture-coordinates", name,
                              "such corners have none");
}

namespace {

// The lines once more, since few want normals: read_obj() need not pay for them.

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

// The normals of an OBJ file that read_obj() has read: `vn` lines, and what `v/vt/vn` says of
// them. Numbers that are none make no normal. Corners that name a normal which is not there have
// none and are noted; of a strict file they throw Error{UnreadableInput}.
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

// Parts of the file are read on all threads, then joined.

// Groups hold until the next, across parts.
void name_faces(const ObjPart& part, PolygonMesh& mesh) {
  AttributeCollector attributes;
  ObjNames names;
  std::int64_t named = 0;
  const auto add_faces_to = [&](std::int64_t face) {
    attributes.add_faces(static_cast<std::size_t>(face - named));
    named = face;
  };
  for (const ObjPart::Naming& naming : part.namings) {
    add_faces_to(naming.faces_before);
    names.take(naming);
    attributes.use_group(names.face_group());
  }
  add_faces_to(part.mesh.face_count());
  PolygonMesh found;
  attributes.finish({}, found);
  mesh.groups = std::move(found.groups);
  mesh.face_groups = std::move(found.face_groups);
}

// Corners that name coordinates which are not there, or are no numbers, have none.
void drop_missing_uvs(ObjPart& part) {
  LineNote& missing = part.notes.missing_uvs;
  if (missing.count == 0 && part.notes.bad_uvs.count == 0) return;
  const bool is_beyond = part.largest_uv.index >= std::ssize(part.uvs);
  std::int64_t beyond = 0;
  for (std::int32_t& uv : part.mesh.face_uvs) {
    if (uv >= std::ssize(part.uvs)) {
      uv = -1;
      ++beyond;
    } else if (uv >= 0 && std::isnan(part.uvs[uv].x)) {
      uv = -1;
    }
  }
  if (is_beyond) missing.count += beyond - 1;
  for (glm::dvec2& uv : part.uvs)
    if (std::isnan(uv.x)) uv = glm::dvec2(0.0);
  const bool any = std::ranges::any_of(part.mesh.face_uvs, [](std::int32_t uv) { return uv >= 0; });
  if (!any) part.mesh.face_uvs = {};
}

// A vertex that no face names may be anywhere: without a place it is put at 0. Otherwise the note
// stays, and the file is refused.
void place_unused(ObjPart& part, std::string_view name, std::vector<Warning>& warnings) {
  LineNote& bad = part.notes.bad_positions;
  std::vector<glm::dvec3>& positions = part.mesh.positions;
  const auto is_bad = [](const glm::dvec3& p) { return !std::isfinite(p.x + p.y + p.z); };
  const bool is_used = std::ranges::any_of(part.mesh.face_vertices, [&](std::int32_t vertex) {
    return vertex < std::ssize(positions) && is_bad(positions[vertex]);
  });
  if (bad.count == 0 || is_used || part.mesh.face_vertices.empty()) return;
  std::ranges::replace_if(positions, is_bad, glm::dvec3(0.0));
  bad.warn(warnings, "missing-positions", name, "no face names such vertices, which are put at 0");
  bad = {};
}

MeshFile read_lines(const FileBytes& file, std::size_t part_bytes) {
  const TextLines whole(file, TextLines::Continuation::Backslash);
  const std::vector<TextLines> lines = whole.cut(part_bytes);
  ObjParts parts(
      lines.size(), [&](std::size_t p, const auto& use) { use(lines[p]); }, /*is_start=*/true);
  ObjPart all = parts.join({});
  MeshFile found{.format = FileFormat::Obj};
  place_unused(all, file.name, found.warnings);
  require_obj(all, all.counts(), whole);
  drop_missing_uvs(all);
  warn_of(all, file.name, found.warnings);
  name_faces(all, all.mesh);
  found.header = std::move(all.header);
  found.dropped_element_count = all.dropped_element_count;
  // Coordinates that no corner names are dropped.
  if (!all.mesh.face_uvs.empty()) all.mesh.uvs = std::move(all.uvs);
  std::ranges::replace(all.mesh.colors, kNoObjColor, glm::vec4(1.0f));
  found.mesh = std::move(all.mesh);
  return found;
}

}  // namespace

MeshFile read_obj(const FileBytes& file, std::size_t part_bytes) {
  if (file.split_normals_crease) expect_passes(file, 2);
  MeshFile found = read_lines(file, part_bytes);
  const bool is_cloud = found.mesh.face_count() == 0 && !found.mesh.positions.empty();
  if (!is_cloud && !file.split_normals_crease) return found;
  LineNote missing;
  CornerNormals normals = read_obj_normals(file, missing);
  missing.warn(found.warnings, "missing-normals", file.name, "such corners have none");
  if (is_cloud) {
    if (normals.values.size() == found.mesh.positions.size())
      found.normals = std::move(normals.values);
    return found;
  }
  weld_repeated_vertices(found);
  mark_split_normals(found.mesh, normals);
  return found;
}

}  // namespace planish
