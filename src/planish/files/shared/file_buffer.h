#pragma once

#include <bit>
#include <charconv>
#include <concepts>
#include <cstddef>
#include <cstring>
#include <string_view>
#include <vector>

#include "planish/core/output_file.h"

namespace planish {

/// Collects numbers and text for an OutputFile in large pieces. finish() must come last: it hands
/// over what is left and commits.
class FileBuffer {
 public:
  explicit FileBuffer(OutputFile& file) : file_(file), bytes_(kBytes) {}

  FileBuffer& text(std::string_view text) {
    for (; text.size() > kRoom; text.remove_prefix(kRoom)) put(text.substr(0, kRoom));
    put(text);
    return *this;
  }
  /// Shortest round-trip text.
  template <class Number>
  requires std::integral<Number> || std::floating_point<Number> FileBuffer& number(Number value) {
    make_room();
    const auto end = std::to_chars(bytes_.data() + used_, bytes_.data() + kBytes, value);
    used_ = static_cast<std::size_t>(end.ptr - bytes_.data());
    return *this;
  }
  /// The bytes of a number, little endian.
  template <class Number>
  FileBuffer& binary(Number value) {
    static_assert(std::endian::native == std::endian::little);
    make_room();
    std::memcpy(bytes_.data() + used_, &value, sizeof(value));
    used_ += sizeof(value);
    return *this;
  }

  void finish() {
    flush();
    file_.commit();
  }

 private:
  static constexpr std::size_t kBytes = std::size_t{1} << 20;
  static constexpr std::size_t kRoom = 64;  // the longest double has 24 characters

  void put(std::string_view text) {
    make_room();
    std::memcpy(bytes_.data() + used_, text.data(), text.size());
    used_ += text.size();
  }
  void make_room() {
    if (used_ + kRoom > kBytes) flush();
  }
  void flush() {
    file_.write(std::string_view(bytes_.data(), used_));
    used_ = 0;
  }

  OutputFile& file_;
  std::vector<char> bytes_;
  std::size_t used_ = 0;
};

}  // namespace planish
