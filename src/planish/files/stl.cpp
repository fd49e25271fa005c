#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/core/words.h"
#include "planish/files/read_file.h"
#include "planish/files/readers.h"
#include "planish/files/shared/text_lines.h"
#include "planish/files/shared/weld.h"
#include "planish/files/writers.h"
#include "planish/mend/repair.h"
#include "planish/mesh/edge_groups.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {
namespace {

// Based on: 3D Systems, "StereoLithography Interface Specification", 1989.

constexpr std::size_t kHeaderBytes = 84;
constexpr std::size_t kTriangleBytes = 50;
constexpr std::size_t kFacetNormalBytes = 12;

bool is_word(std::string_view word, std::string_view expected) {
  return std::ranges::equal(word, expected, {}, [](char c) { return lower_case(c); });
}

// Many binary files begin with `solid`, too: their first triangle has a byte that no text has.
bool is_text(std::span<const std::byte> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (text.substr(0, kHeaderBytes + kTriangleBytes).find('\0') != std::string_view::npos)
    return false;
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  return begin != std::string_view::npos && is_word(text.substr(begin, 5), "solid");
}

// The first coordinate of a binary file that is not finite.
[[noreturn]] void fail_at_first_infinite(std::span<const glm::dvec3> positions,
                                         std::string_view name) {
  for (std::size_t corner = 0; corner < positions.size(); ++corner) {
    for (int axis = 0; axis < 3; ++axis) {
      const auto value = static_cast<float>(positions[corner][axis]);
      if (std::isfinite(value)) continue;
      const auto triangle = static_cast<std::int64_t>(corner / 3);
      throw Error(
          ErrorCode::UnreadableInput,
          formatted("{}: triangle {} has the coordinate {}", name, triangle, shortest(value)),
          triangle);
    }
  }
  assertion_failed("a coordinate is not finite", __FILE__, __LINE__);
}

// Programs compute a corner anew for each triangle that has it, and what float32 rounds then
// differs: by no coordinate more than two of its steps, as far apart as they are at the largest
// coordinate. A format that says nothing of which corners are one leaves it to these.
constexpr double kRoundedSteps = 2;

double largest_part(const glm::dvec3& v) { return std::max({v.x, v.y, v.z}); }

double step_at_largest(std::span<const glm::dvec3> positions) {
  constexpr int kFractionBits = 23;
  double most = 0;
  for (const glm::dvec3& p : positions) most = std::max(most, largest_part(glm::abs(p)));
  return most > 0 ? std::ldexp(1.0, std::ilogb(most) - kFractionBits) : 0;
}

using OpenEdge = std::array<std::int32_t, 2>;

std::vector<OpenEdge> open_edges(const PolygonMesh& mesh) {
  std::vector<OpenEdge> open;
  group_edges(mesh).for_each([&](std::int32_t lower, std::span<const FaceSide> sides) {
    if (sides.size() == 1) open.push_back({lower, sides.front().higher});
  });
  return open;
}

// For each position the one that it is but for rounding, itself where there is none: of the ends of
// open edges only.
std::vector<std::int32_t> rounded_targets(std::span<const glm::dvec3> positions,
                                          std::span<const OpenEdge> open) {
  std::vector<std::int32_t> targets(positions.size()), ends;
  std::iota(targets.begin(), targets.end(), 0);
  for (const OpenEdge& edge : open) ends.insert(ends.end(), edge.begin(), edge.end());
  std::ranges::sort(ends);
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  PolygonMesh mesh;  // one face has them all: its corners say what becomes of each
  for (const std::int32_t end : ends) mesh.positions.push_back(positions[end]);
  std::vector<std::int32_t> all(ends.size());
  std::iota(all.begin(), all.end(), 0);
  mesh.add_face(all);
  const double reach = kRoundedSteps * step_at_largest(positions);
  const double fraction = std::sqrt(3.0) * reach / placement_of(mesh).diagonal;
  if (!(fraction > 0) || !can_weld_within(fraction)) return targets;
  const WeldedMesh welded = weld_vertices(std::move(mesh), fraction);
  if (welded.welded_count == 0) return targets;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const std::int32_t target = ends[welded.source_vertices[welded.mesh.face_vertices[i]]];
    const glm::dvec3 off = glm::abs(positions[ends[i]] - positions[target]);
    if (largest_part(off) <= reach) targets[ends[i]] = target;
  }
  return targets;
}

// What is as small as rounding is not rounded away.
void keep_triangles(const PolygonMesh& mesh, std::vector<std::int32_t>& targets) {
  std::vector<std::uint8_t> is_detail(targets.size(), 0);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto corners = mesh.face(f);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const std::int32_t target = targets[corners[i]];
      if (target == targets[corners[(i + 1) % corners.size()]]) is_detail[target] = 1;
    }
  }
  for (std::size_t v = 0; v < targets.size(); ++v)
    if (is_detail[targets[v]] != 0) targets[v] = static_cast<std::int32_t>(v);
}

// Corners become one only where two open edges do.
void keep_what_stays_open(std::span<const OpenEdge> open, std::vector<std::int32_t>& targets) {
  const auto place_of = [&](const OpenEdge& edge) {
    return std::minmax({targets[edge[0]], targets[edge[1]]});
  };
  std::vector<OpenEdge> edges(open.begin(), open.end());
  std::ranges::sort(edges, {}, place_of);
  std::vector<std::uint8_t> closes(targets.size(), 0);
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
    if (place_of(edges[i]) != place_of(edges[i + 1])) continue;
    for (const OpenEdge& edge : {edges[i], edges[i + 1]})
      for (const std::int32_t vertex : edge) closes[vertex] = 1;
  }
  for (std::size_t v = 0; v < targets.size(); ++v)
    if (closes[v] == 0) targets[v] = static_cast<std::int32_t>(v);
}

// Returns how many corners became one with another.
std::int64_t join_rounded(PolygonMesh& mesh) {
  const std::vector<OpenEdge> open = open_edges(mesh);
  if (open.empty()) return 0;
  std::vector<std::int32_t> numbers = rounded_targets(mesh.positions, open);
  keep_triangles(mesh, numbers);
  keep_what_stays_open(open, numbers);
  // A target is no later position than what becomes it, and stays.
  std::int32_t count = 0;
  for (std::size_t v = 0; v < numbers.size(); ++v) {
    const bool stays = numbers[v] == static_cast<std::int32_t>(v);
    if (stays) mesh.positions[count] = mesh.positions[v];
    numbers[v] = stays ? count++ : numbers[numbers[v]];
  }
  const std::int64_t joined = mesh.vertex_count() - count;
  mesh.positions.resize(count);
  for (std::int32_t& vertex : mesh.face_vertices) vertex = numbers[vertex];
  return joined;
}

// Of three corners a triangle.
MeshFile welded_file(std::span<const glm::dvec3> corners, const FileBytes& from) {
  WeldedPositions welded = weld(corners, from);
  TriangleCollector triangles;
  for (std::size_t c = 0; c < corners.size(); c += 3)
    triangles.add(welded.indices[c], welded.indices[c + 1], welded.indices[c + 2]);
  MeshFile file{.format = FileFormat::Stl};
  const auto merged = std::ssize(corners) - std::ssize(welded.positions);
  triangles.finish(std::move(welded.positions), merged, file);
  const std::int64_t joined = join_rounded(file.mesh);
  file.welded_vertex_count += joined;
  if (joined > 0)
    file.warnings.push_back(
        {.code = "joined-corners",
         .message =
             formatted("{}: {} from another one by rounding only, and {} one with it", from.name,
                       joined == 1 ? "1 corner at an open edge differs"
                                   : formatted("{} corners at open edges differ", joined),
                       joined == 1 ? "is" : "are"),
         .count = joined});
  return file;
}

// Colours have no place in the format: VisCAM and Magics put them into the bytes behind a triangle
// that nobody needs, Magics one for all into the header.
void warn_of_colors(const FileBytes& from, MeshFile& file) {
  const std::span<const std::byte> bytes = from.bytes;
  std::int64_t count = 0;
  for (std::size_t at = kHeaderBytes; at + kTriangleBytes <= bytes.size(); at += kTriangleBytes)
    if (load<std::uint16_t>(bytes.subspan(at + kTriangleBytes - 2)) != 0) ++count;
  const std::string_view header(reinterpret_cast<const char*>(bytes.data()), 80);
  const bool has_common = header.find("COLOR=") != std::string_view::npos;
  if (count == 0 && !has_common) return;
  file.warnings.push_back(
      {.code = "ignored-colors",
       .message = formatted("{}: colours of triangles are left out{}; PLY and OBJ have a place for "
                            "colours, of vertices",
                            from.name,
                            count == 0 ? ", here one for all"
                                       : formatted(", or what else the last two bytes of {} are",
                                                   counted(count, "triangle"))),
       .count = count});
}

MeshFile read_binary(const FileBytes& file) {
  expect_passes(file, 2);  // the second welds
  const std::span<const std::byte> bytes = file.bytes;
  constexpr std::size_t kStlGrain = 4096;
  const auto count = load<std::uint32_t>(bytes.subspan(80));
  RawVector<glm::dvec3> positions(std::size_t{3} * count);
  std::atomic<bool> finite{true};
  parallel_for(count, kStlGrain, [&](std::size_t begin, std::size_t end) {
    bool all = true;
    for (std::size_t triangle = begin; triangle < end; ++triangle) {
      const auto record = bytes.subspan(kHeaderBytes + triangle * kTriangleBytes, kTriangleBytes);
      for (std::size_t corner = 0; corner < 3; ++corner) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const auto value =
              load<float>(record.subspan(kFacetNormalBytes + 12 * corner + 4 * axis));
          all = all && std::isfinite(value);
          positions[3 * triangle + corner][static_cast<int>(axis)] = value;
        }
      }
    }
    if (!all) finite.store(false, std::memory_order_relaxed);
    count_read(file.progress, (end - begin) * kTriangleBytes);
  });
  if (!finite.load()) fail_at_first_infinite(positions, file.name);
  MeshFile found = welded_file(positions, file);
  warn_of_colors(file, found);
  return found;
}

// Reads the facets that begin in a part of the file: a part but the first begins with its first
// facet, which stands in a solid, as the part before makes sure.
class StlPart {
 public:
  // `lines` stand before the part; null for the last: `behind`.
  StlPart(const TextLines& lines, bool is_first, const TextLines* behind)
      : lines_(lines), behind_(behind), inside_(is_first ? Inside::Nothing : Inside::Facet) {}

  void read();

  std::vector<glm::dvec3> corners;  // three of each facet
  LineNote unknown;

 private:
  enum class Inside { Nothing, Solid, Facet, Loop };

  bool find_first_facet();
  void read_line(Words words, std::string_view word);
  void move(Inside from, Inside to, std::string_view word);
  void read_vertex(Words words);

  TextLines lines_;
  const TextLines* behind_;
  Inside inside_;
  std::int64_t loop_begin_ = 0;
};

bool StlPart::find_first_facet() {
  while (lines_.next_with_words())
    if (is_word(Words(lines_.line()).next(), "facet")) return true;
  return false;
}

void StlPart::read() {
  const bool is_first = inside_ == Inside::Nothing;
  if (!is_first && !find_first_facet()) return;
  // A facet behind the part is where another begins.
  if (!is_first && behind_ != nullptr && lines_.is_at_or_behind(*behind_)) return;
  while (lines_.next_with_words()) {
    Words words(lines_.line());
    const std::string_view word = words.next();
    read_line(words, word);
    if (behind_ != nullptr && is_word(word, "facet") && lines_.is_at_or_behind(*behind_)) return;
  }
  if (inside_ != Inside::Nothing && inside_ != Inside::Solid)
    lines_.fail("the file ends inside a facet");
}

void StlPart::read_line(Words words, std::string_view word) {
  if (is_word(word, "vertex")) {
    move(Inside::Loop, Inside::Loop, word);
    read_vertex(words);
  } else if (is_word(word, "facet")) {
    move(Inside::Solid, Inside::Facet, word);
  } else if (is_word(word, "outer")) {
    move(Inside::Facet, Inside::Loop, word);
    loop_begin_ = std::ssize(corners);
  } else if (is_word(word, "endloop")) {
    move(Inside::Loop, Inside::Facet, word);
    if (const std::int64_t count = std::ssize(corners) - loop_begin_; count != 3)
      lines_.fail("facet has " + counted(count, "vertex") + ", 3 are needed");
  } else if (is_word(word, "endfacet")) {
    move(Inside::Facet, Inside::Solid, word);
  } else if (is_word(word, "solid")) {
    move(Inside::Nothing, Inside::Solid, word);
  } else if (is_word(word, "endsolid")) {
    move(Inside::Solid, Inside::Nothing, word);
  } else {
    const std::string what = quote(word) + " is no word of STL";
    if (inside_ == Inside::Facet || inside_ == Inside::Loop) lines_.fail(what);
    lines_.note(unknown, what);
  }
}

void StlPart::move(Inside from, Inside to, std::string_view word) {
  if (inside_ != from) lines_.fail(quote(word) + " is out of place");
  inside_ = to;
}

void StlPart::read_vertex(Words words) {
  glm::dvec3 position;
  for (int axis = 0; axis < 3; ++axis) {
    const std::string_view word = words.next();
    if (!parse_number(word, position[axis]))
      lines_.fail("vertex coordinate " + no_finite_number(word));
  }
  if (const std::string_view word = words.next(); !word.empty())
    lines_.fail("vertex has a fourth value " + quote(word));
  corners.push_back(position);
}

MeshFile read_text(const FileBytes& file, std::size_t part_bytes) {
  expect_passes(file, 3);  // lines are counted, read, and corners welded
  TextLines whole(file);
  const std::vector<TextLines> lines = numbered_parts(whole, part_bytes);
  std::vector<StlPart> parts;
  for (std::size_t p = 0; p < lines.size(); ++p) {
    whole.move_before(lines[p]);
    parts.emplace_back(whole, p == 0, p + 1 < lines.size() ? &lines[p + 1] : nullptr);
  }
  FirstFailure failure;
  parallel_each(parts.size(), 1, [&](std::size_t p) {
    failure.watch(p, [&] { parts[p].read(); });
    lines[p].count();
  });
  failure.rethrow();
  std::vector<glm::dvec3> corners = std::move(parts.front().corners);
  LineNote unknown = parts.front().unknown;
  for (std::size_t p = 1; p < parts.size(); ++p) {
    corners.insert(corners.end(), parts[p].corners.begin(), parts[p].corners.end());
    unknown.join(parts[p].unknown);
    parts[p].corners = {};
  }
  if (corners.size() > std::numeric_limits<std::int32_t>::max())
    throw Error(ErrorCode::UnreadableInput,
                std::string(file.name) + ": more triangle corners than 32 bits can count");
  MeshFile found = welded_file(corners, file);
  unknown.warn(found.warnings, "unknown-keyword", file.name, "such lines are passed over");
  return found;
}

}  // namespace

MeshFile read_stl(const FileBytes& file, std::size_t part_bytes) {
  const std::span<const std::byte> bytes = file.bytes;
  const auto fail = [&](const std::string& what) {
    throw Error(ErrorCode::UnreadableInput, std::string(file.name) + ": " + what);
  };
  if (bytes.size() < kHeaderBytes) {
    if (!is_text(bytes)) fail("neither begins with `solid` nor has a binary header of 84 bytes");
    return read_text(file, part_bytes);
  }
  const std::uint64_t count = load<std::uint32_t>(bytes.subspan(80));
  const std::uint64_t expected = kHeaderBytes + kTriangleBytes * count;
  if (bytes.size() != expected && is_text(bytes)) return read_text(file, part_bytes);
  const auto is_zero = [](std::byte byte) { return byte == std::byte{0}; };
  const bool is_padded = count > 0 && bytes.size() > expected && !file.is_strict &&
                         std::ranges::all_of(bytes.subspan(expected), is_zero);
  if (bytes.size() != expected && !is_padded) {
    const std::uint64_t fitting = (bytes.size() - kHeaderBytes) / kTriangleBytes;
    fail(formatted("header promises {} triangles in {} bytes, but the file has {}{}", count,
                   expected, bytes.size(),
                   bytes.size() == kHeaderBytes + kTriangleBytes * fitting
                       ? formatted(", which {} triangles need", fitting)
                       : ""));
  }
  if (3 * count > std::numeric_limits<std::int32_t>::max())
    fail(formatted("header promises {} triangles, more than 32 bits can count", count));
  FileBytes triangles = file;
  triangles.bytes = bytes.first(expected);
  MeshFile found = read_binary(triangles);
  const auto behind = static_cast<std::int64_t>(bytes.size() - expected);
  if (is_padded)
    found.warnings.push_back(
        {.code = "trailing-zeros",
         .message =
             formatted("{}: {} behind the triangles, from byte {} on, {} left out", file.name,
                       counted(behind, "zero byte"), expected, behind == 1 ? "is" : "are"),
         .count = behind});
  return found;
}

namespace {

void write_vector(FileBuffer& out, const glm::vec3& v) { out.binary(v.x).binary(v.y).binary(v.z); }

void write_triangle(FileBuffer& out, const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
  const glm::dvec3 across =
      glm::cross(glm::dvec3(b) - glm::dvec3(a), glm::dvec3(c) - glm::dvec3(a));
  const double length = glm::length(across);
  write_vector(out, length > 0 ? glm::vec3(across / length) : glm::vec3(0.0f));
  for (const glm::vec3& corner : {a, b, c}) write_vector(out, corner);
  out.binary(std::uint16_t{0});
}

}  // namespace

void write_stl(const PolygonStream& stream) {
  constexpr std::size_t kTitleBytes = 80;
  // A reader takes a file that begins with `solid` for text.
  std::string header = "binary STL by planish";
  header.resize(kTitleBytes, ' ');
  const std::int64_t count = stream.totals().corner_count - 2 * stream.totals().face_count;
  if (count > std::numeric_limits<std::uint32_t>::max())
    throw Error(ErrorCode::InvalidArgument,
                formatted("{}: {} triangles are more than an STL file can hold; use fewer levels",
                          stream.name(), count));
  stream.part(PolygonPart::Head, [&](FileBuffer& out, const PolygonPiece&, RowRange) {
    out.text(header).binary(static_cast<std::uint32_t>(count));
  });
  stream.part(PolygonPart::Triangles, [](FileBuffer& out, const PolygonPiece& piece, RowRange) {
    const std::span<const glm::dvec3> positions = piece.view.positions;
    for (std::size_t i = 0; i < positions.size(); i += 3)
      write_triangle(out, glm::vec3(positions[i]), glm::vec3(positions[i + 1]),
                     glm::vec3(positions[i + 2]));
  });
}

}  // namespace planish
