#pragma once

#include <algorithm>
#include <bit>
#include <charconv>
#include <concepts>
#include <cstddef>
#include <cstring>
#include <functional>
#include <glm/vec3.hpp>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "planish/core/ordered_pipeline.h"
#include "planish/core/raw_vector.h"

namespace planish {

/// Takes the next bytes of a file.
using ByteSink = std::function<void(std::span<const std::byte>)>;

/// Makes the bytes of each range on all threads, make(range, bytes), and gives them to every sink
/// in the order of the ranges. A sink is called by one thread at a time; different sinks, such as a
/// file and its digest, work side by side. Holds a few pieces at once. Throws what they throw.
template <class Make>
void stream(std::span<const RowRange> ranges, const Make& make, std::span<const ByteSink> sinks) {
  // Enough that no stage waits for another's memory.
  std::vector<RawVector<std::byte>> pieces(pipeline_threads() + sinks.size() + 1);
  std::vector<PieceStep> takers;
  for (const ByteSink& sink : sinks)
    takers.emplace_back([&](std::size_t, std::size_t slot) { sink(pieces[slot]); });
  ordered_pipeline(
      ranges.size(), pieces.size(),
      [&](std::size_t i, std::size_t slot) { make(ranges[i], pieces[slot]); }, takers);
}

/// The values of a piece, `count` of them, for make() to fill.
template <class Value>
std::span<Value> values_of(RawVector<std::byte>& bytes, std::size_t count) {
  bytes.resize(count * sizeof(Value));
  return {reinterpret_cast<Value*>(bytes.data()), count};
}

/// Appends numbers and text to the bytes of a piece of a file, whose memory is used again. They are
/// complete after finish(). With a sink it is a whole file that is handed over now and then.
class FileBuffer {
 public:
  explicit FileBuffer(RawVector<std::byte>& bytes, ByteSink sink = {})
      : bytes_(bytes), sink_(std::move(sink)) {
    bytes_.resize(std::max(bytes_.capacity(), kRoom));
  }

  FileBuffer& text(std::string_view text) {
    make_room(text.size());
    std::memcpy(place(), text.data(), text.size());
    used_ += text.size();
    return *this;
  }
  /// Shortest round-trip text.
  template <class Number>
  requires std::integral<Number> || std::floating_point<Number> FileBuffer& number(Number value) {
    make_room(kRoom);
    const auto end = std::to_chars(place(), place() + kRoom, value);
    used_ += static_cast<std::size_t>(end.ptr - place());
    return *this;
  }
  /// The bytes of a number, little endian.
  template <class Number>
  FileBuffer& binary(Number value) {
    static_assert(std::endian::native == std::endian::little);
    make_room(sizeof(value));
    std::memcpy(place(), &value, sizeof(value));
    used_ += sizeof(value);
    return *this;
  }

  void finish() {
    if (sink_) hand_over();
    bytes_.resize(used_);
  }

 private:
  static constexpr std::size_t kRoom = 64;  // the longest double has 24 characters

  [[nodiscard]] char* place() { return reinterpret_cast<char*>(bytes_.data()) + used_; }
  void make_room(std::size_t size) {
    if (sink_ && used_ >= kHandedOver) hand_over();
    if (used_ + size > bytes_.size()) bytes_.resize(2 * bytes_.size() + size);
  }

  void hand_over() {
    sink_(std::span<const std::byte>(bytes_).first(used_));
    used_ = 0;
  }

  static constexpr std::size_t kHandedOver = std::size_t{1} << 20;

  RawVector<std::byte>& bytes_;
  ByteSink sink_;
  std::size_t used_ = 0;
};

/// "x y z" and a line break, as shortest round-trip text.
inline void write_position(FileBuffer& out, const glm::dvec3& position) {
  out.number(position.x).text(" ").number(position.y).text(" ").number(position.z).text("\n");
}

}  // namespace planish
