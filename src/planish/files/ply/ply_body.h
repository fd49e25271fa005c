#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "planish/core/error.h"
#include "planish/core/number_text.h"
#include "planish/files/ply/ply_header.h"
#include "planish/files/shared/bytes.h"
#include "planish/files/shared/text_lines.h"

namespace planish {

/// Where in the file an error is: "vertex 12 of 345".
[[nodiscard]] inline std::string place_of(const PlyElement& element, std::int64_t index) {
  return element.name + " " + std::to_string(index) + " of " + std::to_string(element.count);
}

/// What follows a header, as text.
class PlyTextBody {
 public:
  PlyTextBody(std::span<const std::byte> bytes, std::string_view name)
      : lines_(bytes, name), words_("") {}
  explicit PlyTextBody(const TextLines& lines) : lines_(lines), words_("") {}

  [[nodiscard]] const TextLines& lines() const { return lines_; }

  void skip_header(const PlyHeader& header) {
    while (lines_.number() < header.line_count) (void)lines_.next();
  }
  [[noreturn]] void fail(const std::string& what, std::int64_t index) const {
    lines_.fail(what, index);
  }
  // An entry has at least one digit and one blank or line end for each of its values.
  void require_room(const PlyElement& element) const {
    const std::size_t least = 2 * std::max<std::size_t>(element.properties.size(), 1);
    if (static_cast<std::uint64_t>(element.count) > (lines_.bytes_left() + 1) / least)
      lines_.fail("header promises " + std::to_string(element.count) + " of element " +
                  quote(element.name) + ", but only " + std::to_string(lines_.bytes_left()) +
                  " bytes follow");
  }
  void begin(const PlyElement& element, std::int64_t index) {
    if (!lines_.next_with_words())
      lines_.fail("the file ends at " + place_of(element, index), index);
    words_ = Words(lines_.line());
  }
  void end(const PlyElement& element, std::int64_t index) {
    if (const std::string_view word = words_.next(); !word.empty())
      lines_.fail(place_of(element, index) + " has a value too many: " + quote(word), index);
  }
  void skip(PlyType, const PlyElement& element, std::int64_t index) { (void)word(element, index); }
  double number(PlyType, const PlyElement& element, std::int64_t index) {
    const std::string_view text = word(element, index);
    double value = 0;
    if (!parse_number(text, value))
      lines_.fail(place_of(element, index) + ": " + quote(text) + " is no finite number", index);
    return value;
  }
  /// The same, 0 for what is no finite number.
  double number_or_zero(PlyType, const PlyElement& element, std::int64_t index) {
    double value = 0;
    return parse_number(word(element, index), value) ? value : 0;
  }
  [[nodiscard]] std::size_t values_left(PlyType) const { return words_.rest().size(); }

 private:
  std::string_view word(const PlyElement& element, std::int64_t index) {
    const std::string_view text = words_.next();
    if (text.empty()) lines_.fail(place_of(element, index) + " has too few values", index);
    return text;
  }

  TextLines lines_;
  Words words_;
};

/// The same in binary.
class PlyBinaryBody {
 public:
  PlyBinaryBody(std::span<const std::byte> bytes, std::string_view name)
      : left_(bytes), name_(name) {}

  void skip_header(const PlyHeader& header) {
    left_ = left_.subspan(header.byte_count);
    order_ = header.format == PlyFormat::BigEndian ? std::endian::big : std::endian::little;
  }
  [[noreturn]] void fail(const std::string& what, std::int64_t index) const {
    throw Error(ErrorCode::UnreadableInput, name_ + ": " + what, index);
  }
  void require_room(const PlyElement& element) const {
    const std::size_t least = std::max<std::size_t>(element.least_bytes(), 1);
    if (static_cast<std::uint64_t>(element.count) > left_.size() / least)
      fail("header promises " + std::to_string(element.count) + " of element " +
               quote(element.name) + " of at least " + std::to_string(least) + " bytes, but only " +
               std::to_string(left_.size()) + " bytes follow",
           -1);
  }
  [[nodiscard]] std::size_t bytes_left() const { return left_.size(); }
  /// What follows `count` bytes farther, of which so many must be left.
  [[nodiscard]] PlyBinaryBody behind(std::size_t count) const {
    PlyBinaryBody body = *this;
    body.left_ = left_.subspan(count);
    return body;
  }
  void begin(const PlyElement&, std::int64_t) {}
  void end(const PlyElement&, std::int64_t) {}
  void skip(PlyType type, const PlyElement& element, std::int64_t index) {
    (void)take(byte_count_of(type), element, index);
  }
  double number(PlyType type, const PlyElement& element, std::int64_t index) {
    return number_in(take(byte_count_of(type), element, index), type);
  }
  double number_or_zero(PlyType type, const PlyElement& element, std::int64_t index) {
    const double value = number(type, element, index);
    return std::isfinite(value) ? value : 0;
  }
  /// The number that stands `place` bytes farther, which must be left with the number's own.
  [[nodiscard]] double behind_number(std::size_t place, PlyType type) const {
    return number_in(left_.subspan(place, byte_count_of(type)), type);
  }
  [[nodiscard]] std::size_t values_left(PlyType type) const {
    return left_.size() / byte_count_of(type);
  }

 private:
  [[nodiscard]] double number_in(std::span<const std::byte> bytes, PlyType type) const {
    switch (type) {
      case PlyType::Int8:
        return load<std::int8_t>(bytes, order_);
      case PlyType::UInt8:
        return load<std::uint8_t>(bytes, order_);
      case PlyType::Int16:
        return load<std::int16_t>(bytes, order_);
      case PlyType::UInt16:
        return load<std::uint16_t>(bytes, order_);
      case PlyType::Int32:
        return load<std::int32_t>(bytes, order_);
      case PlyType::UInt32:
        return load<std::uint32_t>(bytes, order_);
      case PlyType::Float32:
        return load<float>(bytes, order_);
      case PlyType::Float64:
        return load<double>(bytes, order_);
    }
    return 0;
  }
  std::span<const std::byte> take(std::size_t count, const PlyElement& element,
                                  std::int64_t index) {
    if (count > left_.size()) fail("the file ends at " + place_of(element, index), index);
    const auto bytes = left_.first(count);
    left_ = left_.subspan(count);
    return bytes;
  }

  std::span<const std::byte> left_;
  std::string name_;
  std::endian order_ = std::endian::little;
};

/// How many values of a list follow. Throws Error{UnreadableInput} where so many cannot.
template <class Body>
std::int64_t ply_list_count(Body& body, const PlyProperty& property, const PlyElement& element,
                            std::int64_t index) {
  const double count = body.number(*property.count_type, element, index);
  if (count < 0 || count != std::floor(count) ||
      count > static_cast<double>(body.values_left(property.type)))
    body.fail(place_of(element, index) + ": list " + quote(property.name) + " promises " +
                  shortest(count) + " values, but no more than " +
                  std::to_string(body.values_left(property.type)) + " can follow",
              index);
  return static_cast<std::int64_t>(count);
}

/// Passes over a property, a list or one value.
template <class Body>
void skip_ply_value(Body& body, const PlyProperty& property, const PlyElement& element,
                    std::int64_t index) {
  const std::int64_t count =
      property.count_type ? ply_list_count(body, property, element, index) : 1;
  for (std::int64_t i = 0; i < count; ++i) body.skip(property.type, element, index);
}

template <class Body>
void skip_ply_element(Body& body, const PlyElement& element) {
  for (std::int64_t index = 0; index < element.count; ++index) {
    body.begin(element, index);
    for (const PlyProperty& property : element.properties)
      skip_ply_value(body, property, element, index);
    body.end(element, index);
  }
}

}  // namespace planish
