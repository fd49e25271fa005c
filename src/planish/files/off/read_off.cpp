// Based on: Geomview manual, "OFF Files".
#include "planish/files/off/read_off.h"

#include <array>
#include <bit>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "planish/core/counted.h"
#include "planish/core/formatted.h"
#include "planish/core/number_text.h"
#include "planish/files/ply/read_ply.h"
#include "planish/files/shared/bytes.h"
#include "planish/files/shared/line_records.h"
#include "planish/files/shared/text_lines.h"

namespace planish {
namespace {

// The shortest lines of a vertex, "0 0 0", and of a face, "0", with their ends.
constexpr std::size_t kLeastVertexBytes = 6;
constexpr std::size_t kLeastFaceBytes = 2;

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
    const LineRecords records(bytes_, lines_, part_bytes_);
    read_vertices(records, vertex_count);
    read_faces(records, vertex_count, face_count);
    TextLines behind = records.before(vertex_count + face_count);
    if (behind.next_with_words()) behind.fail("more follows after the last face");
    return std::move(file_);
  }

 private:
  bool next_line();
  std::string_view read_keyword();
  std::array<std::int64_t, 2> read_counts(std::string_view behind_keyword);
  void read_vertices(const LineRecords& records, std::int64_t count);
  void read_faces(const LineRecords& records, std::int64_t vertex_count, std::int64_t count);
  MeshFile read_binary();

  FileBytes bytes_;
  TextLines lines_;
  std::size_t part_bytes_;
  std::string prefix_;  // of the keyword OFF
  MeshFile file_;
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
  prefix_ = prefix;
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

// What the words of a vertex and of a face say; a failure names what is wrong.
glm::dvec3 vertex_of(const TextLines& lines, std::int64_t vertex) {
  Words words(lines.line());
  glm::dvec3 position;
  for (int axis = 0; axis < 3; ++axis) {
    const std::string_view word = words.next();
    if (!parse_number(word, position[axis]))
      lines.fail("vertex coordinate " + no_finite_number(word), vertex);
  }
  return position;
}

std::int64_t append_face_of(const TextLines& lines, std::int64_t face, std::int64_t vertex_count,
                            std::vector<std::int32_t>& vertices) {
  Words words(lines.line());
  std::string_view word = words.next();
  std::int64_t size = 0;
  if (!parse_integer(word, size) || size < 0)
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

void OffReader::read_vertices(const LineRecords& records, std::int64_t count) {
  std::vector<glm::dvec3>& positions = file_.mesh.positions;
  positions.resize(static_cast<std::size_t>(count));
  records.for_parts(0, count, "vertex",
                    [&](std::size_t, TextLines& lines, std::int64_t begin, std::int64_t end) {
                      for (std::int64_t v = begin; v < end && lines.next_with_words(); ++v)
                        positions[v] = vertex_of(lines, v);
                    });
}

void OffReader::read_faces(const LineRecords& records, std::int64_t vertex_count,
                           std::int64_t count) {
  FaceParts faces;
  faces.parts.resize(records.part_count());
  records.for_parts(vertex_count, vertex_count + count, "face",
                    [&](std::size_t part, TextLines& lines, std::int64_t begin, std::int64_t end) {
                      FaceParts::Part& of = faces.parts[part];
                      for (std::int64_t f = begin; f < end && lines.next_with_words(); ++f)
                        of.sizes.push_back(static_cast<std::int32_t>(
                            append_face_of(lines, f - vertex_count, vertex_count, of.vertices)));
                    });
  const std::int64_t face = faces.append_to(file_.mesh);
  if (face < 0) return;
  TextLines line = records.before(vertex_count + face + 1);
  line.fail("more face corners than 32 bits can count", face);
}

// Numbers of 32 bits, big endian: three counts; vertices with what the keyword promises; faces as
// a list of vertices and one of the components of a colour. That is what a PLY may have.
MeshFile OffReader::read_binary() {
  constexpr std::size_t kCounts = 12;
  const std::size_t begin = bytes_.bytes.size() - lines_.bytes_left();
  if (lines_.bytes_left() < kCounts)
    lines_.fail("the file ends before its counts, 12 bytes behind the keyword");
  const auto count_at = [&](std::size_t at) {
    const auto count = load<std::int32_t>(bytes_.bytes.subspan(begin + at), std::endian::big);
    if (count < 0)
      lines_.fail(formatted("count {} behind the keyword is no integer from 0", count));
    return count;
  };
  const bool has_uvs = prefix_.starts_with("ST");
  const std::string_view behind_uvs = std::string_view(prefix_).substr(has_uvs ? 2 : 0);
  const bool has_colors = behind_uvs.find('C') != std::string_view::npos;
  const bool has_normals = behind_uvs.find('N') != std::string_view::npos;
  PlyElement vertex{.name = "vertex", .count = count_at(0), .properties = {}};
  for (const char* name : {"x", "y", "z"})
    vertex.properties.push_back({.name = name, .type = PlyType::Float32, .count_type = {}});
  // As in text, what stands behind the position is passed over.
  const int passed_over = (has_normals ? 3 : 0) + (has_colors ? 4 : 0) + (has_uvs ? 2 : 0);
  for (int i = 0; i < passed_over; ++i)
    vertex.properties.push_back(
        {.name = "passed over", .type = PlyType::Float32, .count_type = {}});
  const PlyElement face{
      .name = "face",
      .count = count_at(4),
      .properties = {
          {.name = "vertex_indices", .type = PlyType::Int32, .count_type = PlyType::Int32},
          {.name = "color", .type = PlyType::Float32, .count_type = PlyType::Int32}}};
  PlyHeader header{.format = PlyFormat::BigEndian, .elements = {vertex, face}};
  header.byte_count = begin + kCounts;
  MeshFile found = read_binary_ply_body(bytes_, header);
  found.format = FileFormat::Off;
  found.header = std::move(file_.header);
  return found;
}

}  // namespace

MeshFile read_off(const FileBytes& file, std::size_t part_bytes) {
  return OffReader(file, part_bytes).read();
}

}  // namespace planish
