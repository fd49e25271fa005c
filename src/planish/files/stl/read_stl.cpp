// Based on: 3D Systems, "StereoLithography Interface Specification", 1989.
#include "planish/files/stl/read_stl.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "planish/core/assert.h"
#include "planish/core/counted.h"
#include "planish/core/error.h"
#include "planish/core/lower_case.h"
#include "planish/core/number_text.h"
#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/files/shared/bytes.h"
#include "planish/files/shared/first_failure.h"
#include "planish/files/shared/read_progress.h"
#include "planish/files/shared/text_lines.h"
#include "planish/files/shared/weld.h"

namespace planish {
namespace {

constexpr std::size_t kHeaderBytes = 84;
constexpr std::size_t kTriangleBytes = 50;
constexpr std::size_t kNormalBytes = 12;

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

// Of three corners a triangle.
MeshFile welded_file(std::span<const glm::dvec3> corners, const FileBytes& from) {
  WeldedPositions welded = weld(corners, from);
  TriangleCollector triangles;
  for (std::size_t c = 0; c < corners.size(); c += 3)
    triangles.add(welded.indices[c], welded.indices[c + 1], welded.indices[c + 2]);
  MeshFile file{.format = FileFormat::Stl};
  const auto merged = std::ssize(corners) - std::ssize(welded.positions);
  triangles.finish(std::move(welded.positions), merged, file);
  return file;
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
          const auto value = load<float>(record.subspan(kNormalBytes + 12 * corner + 4 * axis));
          all = all && std::isfinite(value);
          positions[3 * triangle + corner][static_cast<int>(axis)] = value;
        }
      }
    }
    if (!all) finite.store(false, std::memory_order_relaxed);
    count_read(file.progress, (end - begin) * kTriangleBytes);
  });
  if (!finite.load()) fail_at_first_infinite(positions, file.name);
  return welded_file(positions, file);
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
  if (bytes.size() == expected) {
    if (3 * count > std::numeric_limits<std::int32_t>::max())
      fail(formatted("header promises {} triangles, more than 32 bits can count", count));
    return read_binary(file);
  }
  if (!is_text(bytes))
    fail(formatted("header promises {} triangles in {} bytes, but the file has {}", count, expected,
                   bytes.size()));
  return read_text(file, part_bytes);
}

}  // namespace planish
