// Based on: Geomview manual, "OFF Files".
#include "planish/files/off/read_off.h"

#include <array>
#include <limits>
#include <vector>

#include "planish/core/number_text.h"
#include "planish/files/shared/line_records.h"
#include "planish/files/shared/text_lines.h"

namespace planish {
namespace {

// The shortest lines of a vertex, "0 0 0", and of a face, "0", with their ends.
constexpr std::size_t kLeastVertexBytes = 6;
constexpr std::size_t kLeastFaceBytes = 2;

class OffReader {
 public:
  OffReader(std::span<const std::byte> bytes, std::string_view name, std::size_t part_bytes)
      : lines_(bytes, name), part_bytes_(part_bytes) {}

  MeshFile read() {
    file_.format = FileFormat::Off;
    const auto [vertex_count, face_count] = read_counts();
    if (read_parts(vertex_count, face_count)) return std::move(file_);
    file_.mesh = {};
    file_.mesh.positions.reserve(vertex_count);
    for (std::int64_t i = 0; i < vertex_count; ++i) read_vertex(i, vertex_count);
    file_.mesh.face_offsets.reserve(face_count + 1);
    for (std::int64_t i = 0; i < face_count; ++i) read_face(i, face_count);
    if (lines_.next_with_words()) lines_.fail("more follows after the last face");
    return std::move(file_);
  }

 private:
  bool next_line();
  std::string_view read_keyword();
  std::array<std::int64_t, 2> read_counts();
  bool read_parts(std::int64_t vertex_count, std::int64_t face_count);
  void read_vertex(std::int64_t vertex, std::int64_t count);
  void read_face(std::int64_t face, std::int64_t count);

  TextLines lines_;
  std::size_t part_bytes_;
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
  Words words(line.substr(end + 3));
  if (words.next() == "BINARY") lines_.fail("binary OFF cannot be read; save it as text");
  return line.substr(end + 3);
}

std::array<std::int64_t, 2> OffReader::read_counts() {
  Words words(read_keyword());
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
      lines_.fail("header promises " + std::to_string(count) + what + ", but only " +
                  std::to_string(lines_.bytes_left()) + " bytes follow");
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
      lines.fail("vertex coordinate " + quote(word) + " is no finite number", vertex);
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
    if (word.empty())
      lines.fail("face has " + std::to_string(i) + " corners of " + std::to_string(size), face);
    std::int64_t vertex = 0;
    if (!parse_integer(word, vertex))
      lines.fail("face corner " + quote(word) + " is no integer", face);
    if (vertex < 0 || vertex >= vertex_count)
      lines.fail(
          "face names vertex " + std::to_string(vertex) + " of " + std::to_string(vertex_count),
          face);
    vertices.push_back(static_cast<std::int32_t>(vertex));
  }
  return size;
}

// On all threads. False where something is wrong: reading one line after another finds the first.
bool OffReader::read_parts(std::int64_t vertex_count, std::int64_t face_count) {
  const LineRecords records(lines_, part_bytes_);
  if (records.part_count() == 1 || records.count() != vertex_count + face_count) return false;
  std::vector<glm::dvec3>& positions = file_.mesh.positions;
  positions.resize(static_cast<std::size_t>(vertex_count));
  FaceParts faces;
  faces.parts.resize(records.part_count());
  const auto read_vertices = [&](std::size_t, TextLines& lines, std::int64_t begin,
                                 std::int64_t end) {
    for (std::int64_t v = begin; v < end && lines.next_with_words(); ++v)
      positions[v] = vertex_of(lines, v);
  };
  const auto read_faces = [&](std::size_t part, TextLines& lines, std::int64_t begin,
                              std::int64_t end) {
    FaceParts::Part& of = faces.parts[part];
    for (std::int64_t f = begin; f < end && lines.next_with_words(); ++f)
      of.sizes.push_back(static_cast<std::int32_t>(
          append_face_of(lines, f - vertex_count, vertex_count, of.vertices)));
  };
  return records.for_parts(0, vertex_count, read_vertices) &&
         records.for_parts(vertex_count, vertex_count + face_count, read_faces) &&
         faces.append_to(file_.mesh);
}

void OffReader::read_vertex(std::int64_t vertex, std::int64_t count) {
  if (!lines_.next_with_words())
    lines_.fail(
        "the file ends at vertex " + std::to_string(vertex) + " of " + std::to_string(count),
        vertex);
  file_.mesh.positions.push_back(vertex_of(lines_, vertex));
}

void OffReader::read_face(std::int64_t face, std::int64_t count) {
  if (!lines_.next_with_words())
    lines_.fail("the file ends at face " + std::to_string(face) + " of " + std::to_string(count),
                face);
  (void)append_face_of(lines_, face, file_.mesh.vertex_count(), file_.mesh.face_vertices);
  if (file_.mesh.face_vertices.size() > std::numeric_limits<std::int32_t>::max())
    lines_.fail("more face corners than 32 bits can count", face);
  file_.mesh.face_offsets.push_back(static_cast<std::int32_t>(file_.mesh.face_vertices.size()));
}

}  // namespace

MeshFile read_off(std::span<const std::byte> bytes, std::string_view name) {
  constexpr std::size_t kPartBytes = std::size_t{1} << 20;
  return read_off_in_parts(bytes, name, kPartBytes);
}

MeshFile read_off_in_parts(std::span<const std::byte> bytes, std::string_view name,
                           std::size_t part_bytes) {
  return OffReader(bytes, name, part_bytes).read();
}

}  // namespace planish
