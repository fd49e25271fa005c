// Based on: 3D Systems, "StereoLithography Interface Specification", 1989.
#include "planish/files/stl/read_stl.h"

#include <algorithm>
#include <atomic>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <limits>

#include "planish/core/assert.h"
#include "planish/core/error.h"
#include "planish/core/number_text.h"
#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/files/shared/bytes.h"
#include "planish/files/shared/text_lines.h"
#include "planish/files/shared/weld.h"

namespace planish {
namespace {

constexpr std::size_t kHeaderBytes = 84;
constexpr std::size_t kTriangleBytes = 50;
constexpr std::size_t kNormalBytes = 12;

bool is_word(std::string_view word, std::string_view expected) {
  return std::ranges::equal(word, expected,
                            [](unsigned char a, unsigned char b) { return std::tolower(a) == b; });
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
      throw Error(ErrorCode::UnreadableInput,
                  std::string(name) + ": triangle " + std::to_string(triangle) +
                      " has the coordinate " + shortest(value),
                  triangle);
    }
  }
  assertion_failed("a coordinate is not finite", __FILE__, __LINE__);
}

MeshFile read_binary(std::span<const std::byte> bytes, std::string_view name) {
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
  });
  if (!finite.load()) fail_at_first_infinite(positions, name);
  WeldedPositions welded = weld(positions);
  TriangleCollector triangles;
  for (std::size_t c = 0; c < positions.size(); c += 3)
    triangles.add(welded.indices[c], welded.indices[c + 1], welded.indices[c + 2]);
  MeshFile file{.format = FileFormat::Stl};
  const auto merged = std::ssize(positions) - std::ssize(welded.positions);
  triangles.finish(std::move(welded.positions), merged, file);
  return file;
}

class TextStl {
 public:
  TextStl(std::span<const std::byte> bytes, std::string_view name) : lines_(bytes, name) {}

  MeshFile read() {
    while (lines_.next_with_words()) read_line();
    if (inside_ != Inside::Nothing && inside_ != Inside::Solid)
      lines_.fail("the file ends inside a facet");
    MeshFile file{.format = FileFormat::Stl};
    triangles_.finish(welder_, file);
    return file;
  }

 private:
  enum class Inside { Nothing, Solid, Facet, Loop };

  void read_line();
  void move(Inside from, Inside to, std::string_view word);
  void read_vertex(Words words);
  void end_loop();

  TextLines lines_;
  Welder welder_;
  TriangleCollector triangles_;
  Inside inside_ = Inside::Nothing;
  std::vector<std::int32_t> loop_;
};

void TextStl::read_line() {
  Words words(lines_.line());
  const std::string_view word = words.next();
  if (is_word(word, "vertex")) {
    move(Inside::Loop, Inside::Loop, word);
    read_vertex(words);
  } else if (is_word(word, "facet")) {
    move(Inside::Solid, Inside::Facet, word);
  } else if (is_word(word, "outer")) {
    move(Inside::Facet, Inside::Loop, word);
    loop_.clear();
  } else if (is_word(word, "endloop")) {
    move(Inside::Loop, Inside::Facet, word);
    end_loop();
  } else if (is_word(word, "endfacet")) {
    move(Inside::Facet, Inside::Solid, word);
  } else if (is_word(word, "solid")) {
    move(Inside::Nothing, Inside::Solid, word);
  } else if (is_word(word, "endsolid")) {
    move(Inside::Solid, Inside::Nothing, word);
  } else {
    lines_.fail(quote(word) + " is no word of STL");
  }
}

void TextStl::move(Inside from, Inside to, std::string_view word) {
  if (inside_ != from) lines_.fail(quote(word) + " is out of place");
  inside_ = to;
}

void TextStl::read_vertex(Words words) {
  glm::dvec3 position;
  for (int axis = 0; axis < 3; ++axis) {
    const std::string_view word = words.next();
    if (!parse_number(word, position[axis]))
      lines_.fail("vertex coordinate " + quote(word) + " is no finite number");
  }
  if (const std::string_view word = words.next(); !word.empty())
    lines_.fail("vertex has a fourth value " + quote(word));
  loop_.push_back(welder_.insert(position));
}

void TextStl::end_loop() {
  if (loop_.size() != 3)
    lines_.fail("facet has " + std::to_string(loop_.size()) + " vertices, 3 are needed");
  if (triangles_.corner_count() + 3 > std::numeric_limits<std::int32_t>::max())
    lines_.fail("more triangle corners than 32 bits can count");
  triangles_.add(loop_[0], loop_[1], loop_[2]);
}

}  // namespace

MeshFile read_stl(std::span<const std::byte> bytes, std::string_view name) {
  const auto fail = [&](const std::string& what) {
    throw Error(ErrorCode::UnreadableInput, std::string(name) + ": " + what);
  };
  if (bytes.size() < kHeaderBytes) {
    if (!is_text(bytes)) fail("neither begins with `solid` nor has a binary header of 84 bytes");
    return TextStl(bytes, name).read();
  }
  const std::uint64_t count = load<std::uint32_t>(bytes.subspan(80));
  const std::uint64_t expected = kHeaderBytes + kTriangleBytes * count;
  if (bytes.size() == expected) {
    if (3 * count > std::numeric_limits<std::int32_t>::max())
      fail("header promises " + std::to_string(count) + " triangles, more than 32 bits can count");
    return read_binary(bytes, name);
  }
  if (!is_text(bytes))
    fail("header promises " + std::to_string(count) + " triangles in " + std::to_string(expected) +
         " bytes, but the file has " + std::to_string(bytes.size()));
  return TextStl(bytes, name).read();
}

}  // namespace planish
