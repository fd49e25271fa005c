#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <initializer_list>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/words.h"
#include "planish/files/ply/read_ply.h"
#include "planish/files/read_file.h"
#include "planish/files/readers.h"
#include "planish/files/shared/attributes.h"
#include "planish/files/shared/ordered_stream.h"
#include "planish/files/shared/text_lines.h"
#include "planish/files/writers.h"

namespace planish {
namespace {

// Based on: Geomview manual, "OFF Files".

// The shortest lines of a vertex, "0 0 0", and of a face, "0", with their ends.
constexpr std::size_t kLeastVertexBytes = 6;
constexpr std::size_t kLeastFaceBytes = 2;

constexpr std::size_t kNormal = 3, kColor = 4, kUv = 2;  // numbers of a vertex
constexpr std::size_t kMostExtras = kNormal + kColor + kUv;

class OffReader {
 public:
  OffReader(const FileBytes& file, std::size_t part_bytes)
      : bytes_(file), lines_(TextLines::of_header(file)), part_bytes_(part_bytes) {}

  MeshFile read() {
    file_.format = FileFormat::Off;
    const std::string_view rest = read_keyword();
    if (Words(rest).next() == "BINARY") return read_binary();
    lines_ = TextLines(bytes_);
    file_.header.clear();
    const auto [vertex_count, face_count] = read_counts(read_keyword());
    try {
      read_lines(vertex_count, face_count);
    } catch (const Error& error) {
      const bool may_be_wrapped = error.code() == ErrorCode::UnreadableInput && !bytes_.is_strict;
      if (!may_be_wrapped || !read_wrapped(vertex_count, face_count)) throw;
    }
    finish();
    return std::move(file_);
  }

 private:
  bool next_line();
  std::string_view read_keyword();
  std::array<std::int64_t, 2> read_counts(std::string_view behind_keyword);
  void make_room(std::int64_t vertex_count);
  void set_extras(std::span<const double> numbers, std::int64_t vertex);
  void read_lines(std::int64_t vertex_count, std::int64_t face_count);
  void read_vertices(const LineRecords& records, std::int64_t count);
  void read_faces(const LineRecords& records, std::int64_t vertex_count, std::int64_t count);
  bool read_wrapped(std::int64_t vertex_count, std::int64_t face_count);
  void finish();
  void warn(const char* code, std::int64_t count, const char* what);
  MeshFile read_binary();

  FileBytes bytes_;
  TextLines lines_;
  std::size_t part_bytes_;
  bool has_uvs_ = false, has_colors_ = false, has_normals_ = false;  // by the keyword's prefix
  MeshFile file_;
  LineNote excess_, face_colors_;
};

// Comments before the counts may be the header of a cage.
bool OffReader::next_line() {
  constexpr std::string_view kHeader = "# planish ";
  while (lines_.next()) {
    if (lines_.line().starts_with(kHeader)) file_.header.emplace_back(lines_.line().substr(2));
    if (!Words(lines_.line()).next().empty()) return true;
  }
  return false;
}

// Returns what stands behind the keyword on its line: some writers put the counts there.
std::string_view OffReader::read_keyword() {
  if (!next_line()) lines_.fail("the file is empty");
  const std::string_view line = lines_.line();
  const std::size_t begin = line.find_first_not_of(" \t");
  const std::size_t end = line.find("OFF");
  const std::string_view prefix =
      end == std::string_view::npos ? line : line.substr(begin, end - begin);
  if (end == std::string_view::npos || prefix.size() > 5)
    lines_.fail(quote(Words(line).next()) + " stands in the place of OFF");
  std::string_view rest = prefix;
  for (const std::string_view part : {"ST", "C", "N"})
    if (rest.starts_with(part)) rest.remove_prefix(part.size());
  if (!rest.empty())
    lines_.fail(quote(line.substr(begin, end + 3 - begin)) +
                ": only three-dimensional OFF with the prefixes ST, C and N can be read");
  has_uvs_ = prefix.starts_with("ST");
  const std::string_view behind_uvs = prefix.substr(has_uvs_ ? 2 : 0);
  has_colors_ = behind_uvs.find('C') != std::string_view::npos;
  has_normals_ = behind_uvs.find('N') != std::string_view::npos;
  return line.substr(end + 3);
}

std::array<std::int64_t, 2> OffReader::read_counts(std::string_view behind_keyword) {
  Words words(behind_keyword);
  std::string_view word = words.next();
  if (word.empty()) {
    if (!next_line()) lines_.fail("the file ends before its counts");
    words = Words(lines_.line());
    word = words.next();
  }
  std::array<std::int64_t, 2> counts{};
  for (std::int64_t& count : counts) {
    if (!parse_integer(word, count) || count < 0)
      lines_.fail("count " + quote(word) + " is no integer from 0");
    word = words.next();
  }
  // The third count, of edges, is often wrong and never used.
  const std::size_t left = lines_.bytes_left() + 1;  // the last line may lack its end
  for (const auto& [count, least, what] : {std::tuple(counts[0], kLeastVertexBytes, " vertices"),
                                           std::tuple(counts[1], kLeastFaceBytes, " faces")}) {
    if (static_cast<std::uint64_t>(count) > left / least ||
        count >= std::numeric_limits<std::int32_t>::max())
      lines_.fail(formatted("header promises {}{}, but only {} bytes follow", count, what,
                            lines_.bytes_left()));
  }
  return counts;
}

void OffReader::make_room(std::int64_t vertex_count) {
  PolygonMesh& mesh = file_.mesh = {};
  const auto count = static_cast<std::size_t>(vertex_count);
  mesh.positions.resize(count);
  if (has_colors_) mesh.colors.resize(count);
  if (has_uvs_) mesh.uvs.resize(count);
}

// What the words of a vertex and of a face say; a failure names what is wrong.
template <class Text>
glm::dvec3 position_of(Text& words, const TextLines& lines, std::int64_t vertex) {
  glm::dvec3 position;
  for (int axis = 0; axis < 3; ++axis) {
    const std::string_view word = words.next();
    if (!parse_number(word, position[axis]))
      lines.fail("vertex coordinate " + no_finite_number(word), vertex);
  }
  return position;
}

// The end of a line ends its face.
constexpr std::size_t kAnySize = std::numeric_limits<std::int32_t>::max();

template <class Text>
std::int64_t append_face_of(Text& words, std::size_t most, const TextLines& lines,
                            std::int64_t face, std::int64_t vertex_count,
                            std::vector<std::int32_t>& vertices) {
  std::string_view word = words.next();
  std::int64_t size = 0;
  if (!parse_integer(word, size) || size < 0 || size > static_cast<std::int64_t>(most))
    lines.fail("face size " + quote(word) + " is no integer from 0", face);
  for (std::int64_t i = 0; i < size; ++i) {
    word = words.next();
    if (word.empty()) lines.fail(formatted("face has {} of {}", counted(i, "corner"), size), face);
    std::int64_t vertex = 0;
    if (!parse_integer(word, vertex))
      lines.fail("face corner " + quote(word) + " is no integer", face);
    if (vertex < 0 || vertex >= vertex_count)
      lines.fail(formatted("face names vertex {} of {}", vertex, vertex_count), face);
    vertices.push_back(static_cast<std::int32_t>(vertex));
  }
  return size;
}

// The numbers behind a position: a normal, a colour of three or four, texture coordinates. Those
// that are none are NaN, for the mesh as for finish().
void OffReader::set_extras(std::span<const double> numbers, std::int64_t vertex) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const std::size_t normal = has_normals_ ? kNormal : 0, uv = has_uvs_ ? kUv : 0;
  PolygonMesh& mesh = file_.mesh;
  if (has_uvs_)
    mesh.uvs[vertex] = numbers.size() < normal + uv
                           ? glm::dvec2(kNone)
                           : glm::dvec2(numbers[numbers.size() - 2], numbers.back());
  if (!has_colors_) return;
  const std::size_t size = numbers.size() < normal + uv ? 0 : numbers.size() - normal - uv;
  glm::vec4 color(kNone, kNone, kNone, kNone);
  if (size == kColor || size + 1 == kColor) {
    color.a = 1;
    for (std::size_t c = 0; c < size; ++c)
      color[static_cast<int>(c)] = static_cast<float>(numbers[normal + c]);
  }
  mesh.colors[vertex] = color;
}

void OffReader::read_vertices(const LineRecords& records, std::int64_t count) {
  std::vector<LineNote> excess(records.part_count());
  const bool has_extras = has_colors_ || has_uvs_;
  const auto read = [&](const TextLines& lines, std::int64_t vertex, LineNote& more) {
    Words words(lines.line());
    file_.mesh.positions[vertex] = position_of(words, lines, vertex);
    std::array<double, kMostExtras> numbers{};
    std::size_t found = 0;
    std::string_view word = words.next();
    for (; !word.empty() && found < numbers.size(); word = words.next(), ++found)
      if (!parse_number(word, numbers[found]))
        numbers[found] = std::numeric_limits<double>::quiet_NaN();
    if (has_extras) set_extras(std::span(numbers).first(found), vertex);
    if (!word.empty() || (found > 0 && !has_extras && !has_normals_))
      more.add(lines.number(), "vertex has more than its position", vertex);
  };
  records.for_parts(0, count, "vertex",
                    [&](std::size_t part, TextLines& lines, std::int64_t begin, std::int64_t end) {
                      for (std::int64_t v = begin; v < end && lines.next_with_words(); ++v)
                        read(lines, v, excess[part]);
                    });
  for (const LineNote& of_part : excess) excess_.join(of_part);
}

void OffReader::read_faces(const LineRecords& records, std::int64_t vertex_count,
                           std::int64_t count) {
  FaceParts faces;
  faces.parts.resize(records.part_count());
  std::vector<LineNote> colors(records.part_count());
  const auto read = [&](const TextLines& lines, std::int64_t face, std::size_t part) {
    Words words(lines.line());
    FaceParts::Part& of = faces.parts[part];
    of.sizes.push_back(static_cast<std::int32_t>(
        append_face_of(words, kAnySize, lines, face, vertex_count, of.vertices)));
    if (!words.next().empty()) colors[part].add(lines.number(), "face has a colour", face);
  };
  records.for_parts(vertex_count, vertex_count + count, "face",
                    [&](std::size_t part, TextLines& lines, std::int64_t begin, std::int64_t end) {
                      for (std::int64_t f = begin; f < end && lines.next_with_words(); ++f)
                        read(lines, f - vertex_count, part);
                    });
  for (const LineNote& of_part : colors) face_colors_.join(of_part);
  const std::int64_t face = faces.append_to(file_.mesh);
  if (face < 0) return;
  TextLines line = records.before(vertex_count + face + 1);
  line.fail("more face corners than 32 bits can count", face);
}

void OffReader::read_lines(std::int64_t vertex_count, std::int64_t face_count) {
  make_room(vertex_count);
  const LineRecords records(bytes_, lines_, part_bytes_);
  read_vertices(records, vertex_count);
  read_faces(records, vertex_count, face_count);
  TextLines behind = records.before(vertex_count + face_count);
  if (behind.next_with_words()) behind.fail("more follows after the last face");
}

// The format is words, whatever lines they stand in. Only the ends of lines tell where colours of
// faces end, so that faces have none here; that the words end with the last face says that all of
// them are what they are taken for. False where that is not so.
bool OffReader::read_wrapped(std::int64_t vertex_count, std::int64_t face_count) {
  make_room(vertex_count);
  excess_ = face_colors_ = {};
  FreeWords words(lines_);
  const std::size_t extras =
      (has_normals_ ? kNormal : 0) + (has_colors_ ? kColor : 0) + (has_uvs_ ? kUv : 0);
  std::array<double, kMostExtras> numbers{};
  FaceParts faces;
  faces.parts.resize(1);
  FaceParts::Part& part = faces.parts.front();
  try {
    for (std::int64_t v = 0; v < vertex_count; ++v) {
      file_.mesh.positions[v] = position_of(words, words.lines(), v);
      for (double& number : std::span(numbers).first(extras))
        if (!parse_number(words.next(), number)) return false;
      set_extras(std::span(numbers).first(extras), v);
    }
    for (std::int64_t f = 0; f < face_count; ++f)
      part.sizes.push_back(static_cast<std::int32_t>(append_face_of(
          words, words.bytes_left(), words.lines(), f, vertex_count, part.vertices)));
  } catch (const Error& error) {
    if (error.code() != ErrorCode::UnreadableInput) throw;
    return false;
  }
  if (!words.next().empty() || faces.append_to(file_.mesh) >= 0) return false;
  file_.warnings.push_back(
      {.code = "wrapped-lines",
       .message = formatted("{}: vertices and faces go over lines; the numbers are read one after "
                            "another, and are as many as wanted",
                            bytes_.name)});
  return true;
}

// Colours and coordinates as the mesh has them.
void OffReader::finish() {
  PolygonMesh& mesh = file_.mesh;
  if (has_uvs_) {
    mesh.face_uvs = mesh.face_vertices;
    const auto is_number = [](const glm::dvec2& uv) {
      return std::isfinite(uv.x) && std::isfinite(uv.y);
    };
    for (std::int32_t& uv : mesh.face_uvs)
      if (!is_number(mesh.uvs[uv])) uv = -1;
    const auto without = std::ranges::count_if(mesh.uvs, std::not_fn(is_number));
    for (glm::dvec2& uv : mesh.uvs)
      if (!is_number(uv)) uv = glm::dvec2(0.0);
    if (without > 0) warn("missing-texture-coordinates", without, " lack texture coordinates");
  }
  const auto bad = std::ranges::count_if(mesh.colors, [](const glm::vec4& color) {
    return !std::isfinite(color.r + color.g + color.b + color.a);
  });
  if (bad > 0) warn("missing-colors", bad, " have no colour of three or four numbers: white");
  settle_colors(mesh.colors, bytes_.name, /*whole_is_usual=*/true, file_.warnings);
  excess_.warn(file_.warnings, "excess-values", bytes_.name,
               "what the keyword does not promise is left out");
  face_colors_.warn(file_.warnings, "ignored-colors", bytes_.name,
                    "colours of faces are left out; those of vertices are read");
}

void OffReader::warn(const char* code, std::int64_t count, const char* what) {
  file_.warnings.push_back({.code = code,
                            .message = formatted("{}: {} of {} vertices{}", bytes_.name, count,
                                                 file_.mesh.vertex_count(), what),
                            .count = count});
}

// How numbers of 32 bits stand in a binary file.
struct OffLayout {
  std::endian order;
  bool has_face_colors;  // a count, which may be 0, and as many components behind each face
};

// The first is the specification's. Another program writes the machine's own numbers and faces
// alone.
constexpr std::array kOffLayouts{OffLayout{std::endian::big, true},
                                 OffLayout{std::endian::little, false}};
constexpr std::size_t kOffCounts = 12;  // bytes

// What counts say of the bytes from the three counts on.
struct OffWalk {
  bool ends_with_file = false;
  std::int64_t colored_faces = 0;
};

OffWalk walk(std::span<const std::byte> bytes, const OffLayout& layout, std::size_t vertex_bytes) {
  const auto count_at = [&](std::uint64_t at) {
    return load<std::int32_t>(bytes.subspan(at), layout.order);
  };
  const std::int32_t vertices = count_at(0), faces = count_at(4);
  OffWalk found;
  if (vertices < 0 || faces < 0) return found;
  std::uint64_t at = kOffCounts + static_cast<std::uint64_t>(vertices) * vertex_bytes;
  const auto pass_list = [&](std::int32_t& count) {
    if (at > bytes.size() || bytes.size() - at < sizeof count) return false;
    count = count_at(at);
    at += sizeof count * (std::uint64_t{1} + static_cast<std::uint32_t>(count));
    return count >= 0 && at <= bytes.size();
  };
  for (std::int32_t f = 0; f < faces; ++f) {
    std::int32_t corners = 0, components = 0;
    if (!pass_list(corners) || (layout.has_face_colors && !pass_list(components))) return found;
    if (components > 0) ++found.colored_faces;
  }
  found.ends_with_file = at == bytes.size();
  return found;
}

// Three counts; vertices with what the keyword promises; faces as lists. That is what a PLY may
// have. Which layout it is the counts tell: they have to end with the file.
MeshFile OffReader::read_binary() {
  const std::size_t begin = bytes_.bytes.size() - lines_.bytes_left();
  if (lines_.bytes_left() < kOffCounts)
    lines_.fail("the file ends before its counts, 12 bytes behind the keyword");
  PlyElement vertex{.name = "vertex", .properties = {}}, face{.name = "face", .properties = {}};
  const auto promise = [&](std::initializer_list<const char*> names) {
    for (const char* name : names)
      vertex.properties.push_back({.name = name, .type = PlyType::Float32, .count_type = {}});
  };
  promise({"x", "y", "z"});
  if (has_normals_) promise({"nx", "ny", "nz"});
  if (has_colors_) promise({"red", "green", "blue", "alpha"});
  if (has_uvs_) promise({"s", "t"});
  const auto body = bytes_.bytes.subspan(begin);
  OffWalk found;
  const OffLayout* layout = nullptr;
  for (const OffLayout& tried : kOffLayouts) {
    found = walk(body, tried, vertex.least_bytes());
    if (!found.ends_with_file) continue;
    layout = &tried;
    break;
  }
  if (layout == nullptr) layout = &kOffLayouts.front();
  const auto count_at = [&](std::size_t at) {
    const auto count = load<std::int32_t>(body.subspan(at), layout->order);
    const std::uint64_t least = at == 0 ? vertex.least_bytes() : sizeof count;
    if (count < 0 || static_cast<std::uint64_t>(count) > body.size() / least)
      lines_.fail(
          formatted("count {} behind the keyword does not fit {} bytes, nor does it in the "
                    "other byte order",
                    count, body.size()));
    return count;
  };
  vertex.count = count_at(0);
  face.count = count_at(4);
  face.properties.push_back(
      {.name = "vertex_indices", .type = PlyType::Int32, .count_type = PlyType::Int32});
  if (layout->has_face_colors)
    face.properties.push_back(
        {.name = "color", .type = PlyType::Float32, .count_type = PlyType::Int32});
  PlyHeader header{
      .format = layout->order == std::endian::big ? PlyFormat::BigEndian : PlyFormat::LittleEndian,
      .elements = {std::move(vertex), std::move(face)}};
  header.byte_count = begin + kOffCounts;
  MeshFile read = read_binary_ply_body(bytes_, header);
  read.format = FileFormat::Off;
  read.header = std::move(file_.header);
  if (layout != &kOffLayouts.front())
    read.warnings.push_back(
        {.code = "binary-layout",
         .message =
             formatted("{}: numbers are little-endian and faces without colours, which is not "
                       "as the format has it; so they are read, since their counts end with "
                       "the file",
                       bytes_.name)});
  if (found.colored_faces > 0)
    read.warnings.push_back(
        {.code = "ignored-colors",
         .message = formatted("{}: colours of {} are left out; those of vertices are read",
                              bytes_.name, counted(found.colored_faces, "face")),
         .count = found.colored_faces});
  return read;
}

}  // namespace

MeshFile read_off(const FileBytes& file, std::size_t part_bytes) {
  return OffReader(file, part_bytes).read();
}

void write_off(const PolygonStream& stream) {
  for (const PolygonPart part : kOffParts) {
    stream.part(part, [&](FileBuffer& out, const PolygonPiece& piece, RowRange) {
      const PolygonView& view = piece.view;
      if (part == PolygonPart::Head) {
        out.text("OFF\n");
        for (const std::string& line : view.header) out.text("# ").text(line).text("\n");
        out.number(piece.totals.row_count).text(" ").number(piece.totals.face_count);
        out.text(" 0\n");
      }
      for (const glm::dvec3& position : view.positions) write_position(out, position);
      for (std::size_t face = 0; face < view.face_count(); ++face) {
        const auto corners = view.face(face);
        out.number(corners.size());
        for (const std::int32_t vertex : corners) out.text(" ").number(vertex);
        out.text("\n");
      }
    });
  }
}

}  // namespace planish
