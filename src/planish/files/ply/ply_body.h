#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/number_text.h"
#include "planish/core/parallel.h"
#include "planish/core/visible_text.h"
#include "planish/files/ply/ply_header.h"
#include "planish/files/shared/bytes.h"
#include "planish/files/shared/line_records.h"
#include "planish/files/shared/read_progress.h"

namespace planish {

/// Where in the file an error is: "vertex 12 of 345".
[[nodiscard]] inline std::string place_of(const PlyElement& element, std::int64_t index) {
  return formatted("{} {} of {}", visible(element.name), index, element.count);
}

/// The number at the beginning of `bytes`.
[[nodiscard]] inline double ply_number(std::span<const std::byte> bytes, PlyType type,
                                       std::endian order) {
  switch (type) {
    case PlyType::Int8:
      return load<std::int8_t>(bytes, order);
    case PlyType::UInt8:
      return load<std::uint8_t>(bytes, order);
    case PlyType::Int16:
      return load<std::int16_t>(bytes, order);
    case PlyType::UInt16:
      return load<std::uint16_t>(bytes, order);
    case PlyType::Int32:
      return load<std::int32_t>(bytes, order);
    case PlyType::UInt32:
      return load<std::uint32_t>(bytes, order);
    case PlyType::Float32:
      return load<float>(bytes, order);
    case PlyType::Float64:
      return load<double>(bytes, order);
  }
  return 0;
}

/// Words of one line after another.
class LineWords {
 public:
  explicit LineWords(const TextLines& lines) : lines_(lines), words_("") {}

  void begin() {
    (void)lines_.next_with_words();
    words_ = Words(lines_.line());
  }
  [[nodiscard]] std::string_view next() { return words_.next(); }
  /// A word that is left of the line.
  [[nodiscard]] std::string_view left() { return words_.next(); }
  [[nodiscard]] const TextLines& lines() const { return lines_; }
  [[nodiscard]] std::size_t bytes_left() const { return words_.rest().size(); }

 private:
  TextLines lines_;
  Words words_;
};

/// The same of entries that go over lines: nothing is left of one.
class WrappedWords : public FreeWords {
 public:
  using FreeWords::FreeWords;
  void begin() {}
  [[nodiscard]] std::string_view left() const { return {}; }
};

/// Reads values from what follows a header, as text.
template <class Text>
class PlyWordCursor {
 public:
  explicit PlyWordCursor(const TextLines& lines) : words_(lines) {}

  [[noreturn]] void fail(const std::string& what, std::int64_t index) const {
    words_.lines().fail(what, index);
  }
  void note(LineNote& note, const std::string& what, std::int64_t index) const {
    words_.lines().note(note, what, index);
  }
  void begin() { words_.begin(); }
  void end(const PlyElement& element, std::int64_t index, LineNote& excess) {
    if (const std::string_view word = words_.left(); !word.empty())
      note(excess, place_of(element, index) + " has a value too many: " + quote(word), index);
  }
  void skip(PlyType, std::int64_t count, const PlyElement& element, std::int64_t index) {
    while (count-- > 0) (void)word(element, index);
  }
  double number(PlyType, const PlyElement& element, std::int64_t index) {
    const std::string_view text = word(element, index);
    double value = 0;
    if (!parse_number(text, value))
      fail(place_of(element, index) + ": " + no_finite_number(text), index);
    return value;
  }
  /// The same, but words for what is not finite are numbers too.
  double any_number(PlyType, const PlyElement& element, std::int64_t index) {
    const std::string_view text = word(element, index);
    double value = 0;
    if (parse_number(text, value)) return value;
    if (is_nan_word(text)) return std::numeric_limits<double>::quiet_NaN();
    if (!is_non_finite_word(text))
      fail(place_of(element, index) + ": " + no_finite_number(text), index);
    const double infinite = std::numeric_limits<double>::infinity();
    return text.starts_with('-') ? -infinite : infinite;
  }
  /// The same, NaN for what is no finite number.
  double number_or_nan(PlyType, const PlyElement& element, std::int64_t index) {
    double value = 0;
    return parse_number(word(element, index), value) ? value
                                                     : std::numeric_limits<double>::quiet_NaN();
  }
  [[nodiscard]] std::size_t values_left(PlyType) const { return words_.bytes_left(); }
  /// Whether so many can follow.
  [[nodiscard]] bool has_values(double count, PlyType type) const {
    return count <= static_cast<double>(values_left(type));
  }

  /// Whether nothing follows.
  [[nodiscard]] bool is_at_end() { return words_.next().empty(); }

 private:
  std::string_view word(const PlyElement& element, std::int64_t index) {
    const std::string_view text = words_.next();
    if (text.empty()) fail(place_of(element, index) + " has too few values", index);
    return text;
  }

  Text words_;
};
using PlyTextCursor = PlyWordCursor<LineWords>;
using PlyWrappedCursor = PlyWordCursor<WrappedWords>;

/// The same in binary.
class PlyBinaryCursor {
 public:
  PlyBinaryCursor(const FileBytes& file, const PlyHeader& header)
      : left_(file.bytes.subspan(header.byte_count)),
        name_(file.name),
        order_(header.format == PlyFormat::BigEndian ? std::endian::big : std::endian::little),
        is_strict_(file.is_strict) {}

  [[noreturn]] void fail(const std::string& what, std::int64_t index) const {
    throw Error(ErrorCode::UnreadableInput, name_ + ": " + what, index);
  }
  void note(LineNote& note, const std::string& what, std::int64_t index) const {
    if (is_strict_) fail(what, index);
    note.add(0, what, index);
  }
  [[nodiscard]] std::size_t bytes_left() const { return left_.size(); }
  /// What follows `count` bytes farther, of which so many must be left.
  [[nodiscard]] PlyBinaryCursor behind(std::size_t count) const {
    PlyBinaryCursor cursor = *this;
    cursor.left_ = left_.subspan(count);
    return cursor;
  }
  void begin() {}
  void end(const PlyElement&, std::int64_t, LineNote&) {}
  void skip(PlyType type, std::int64_t count, const PlyElement& element, std::int64_t index) {
    (void)take(static_cast<std::size_t>(count) * byte_count_of(type), element, index);
  }
  double any_number(PlyType type, const PlyElement& element, std::int64_t index) {
    return ply_number(take(byte_count_of(type), element, index), type, order_);
  }
  double number(PlyType type, const PlyElement& element, std::int64_t index) {
    return any_number(type, element, index);
  }
  double number_or_nan(PlyType type, const PlyElement& element, std::int64_t index) {
    return any_number(type, element, index);
  }
  [[nodiscard]] std::size_t values_left(PlyType type) const {
    return left_.size() / byte_count_of(type);
  }
  [[nodiscard]] bool has_values(double count, PlyType type) const {
    return count * static_cast<double>(byte_count_of(type)) <= static_cast<double>(left_.size());
  }

 private:
  std::span<const std::byte> take(std::size_t count, const PlyElement& element,
                                  std::int64_t index) {
    if (count > left_.size()) fail("the file ends at " + place_of(element, index), index);
    const auto bytes = left_.first(count);
    left_ = left_.subspan(count);
    return bytes;
  }

  std::span<const std::byte> left_;
  std::string name_;
  std::endian order_;
  bool is_strict_;
};

/// How many values of a list follow. Throws Error{UnreadableInput} where so many cannot.
template <class Cursor>
std::int64_t ply_list_count(Cursor& cursor, const PlyProperty& property, const PlyElement& element,
                            std::int64_t index) {
  const double count = cursor.number(*property.count_type, element, index);
  if (count < 0 || count != std::floor(count) || !cursor.has_values(count, property.type))
    cursor.fail(formatted("{}: list {} promises {} values, but no more than {} can follow",
                          place_of(element, index), quote(property.name), shortest(count),
                          cursor.values_left(property.type)),
                index);
  return static_cast<std::int64_t>(count);
}

/// Passes over a property, a list or one value.
template <class Cursor>
void skip_ply_value(Cursor& cursor, const PlyProperty& property, const PlyElement& element,
                    std::int64_t index) {
  const std::int64_t count =
      property.count_type ? ply_list_count(cursor, property, element, index) : 1;
  cursor.skip(property.type, count, element, index);
}

/// What follows the header of a text file.
[[nodiscard]] TextLines ply_lines_behind(const FileBytes& file, const PlyHeader& header);

/// What follows a header, element after element, each in pieces that threads read side by side.
class PlyTextBody {
 public:
  using Cursor = PlyTextCursor;

  PlyTextBody(const FileBytes& file, const PlyHeader& header, std::size_t part_bytes)
      : records_(file, ply_lines_behind(file, header), part_bytes) {}

  [[noreturn]] void fail(const std::string& what, std::int64_t index) const {
    records_.before(first_).fail(what, index);
  }
  /// Throws Error{UnreadableInput} where the next element cannot have as many entries as it says.
  void require_room(const PlyElement& element) const;
  /// Of the next element.
  [[nodiscard]] std::size_t piece_count(const PlyElement&) { return records_.part_count(); }
  /// Calls read(piece, cursor, begin, end) for the entries [begin, end) of each piece; the cursor
  /// stands before them. Throws the Error{UnreadableInput} of the first entry that is wrong.
  template <class Read>
  void for_pieces(const PlyElement& element, const Read& read) {
    records_.for_parts(
        first_, first_ + element.count, element.name,
        [&](std::size_t piece, const TextLines& lines, std::int64_t begin, std::int64_t end) {
          PlyTextCursor cursor(lines);
          read(piece, cursor, begin - first_, end - first_);
        });
    first_ += element.count;
  }

 private:
  LineRecords records_;
  std::int64_t first_ = 0;  // record of the next element
};

/// The same of text whose entries go over lines.
class PlyWrappedBody {
 public:
  using Cursor = PlyWrappedCursor;

  PlyWrappedBody(const FileBytes& file, const PlyHeader& header, std::size_t)
      : cursor_(ply_lines_behind(file, header)) {}

  [[noreturn]] void fail(const std::string& what, std::int64_t index) const {
    cursor_.fail(what, index);
  }
  void require_room(const PlyElement& element) const;
  [[nodiscard]] std::size_t piece_count(const PlyElement&) { return 1; }
  template <class Read>
  void for_pieces(const PlyElement& element, const Read& read) {
    read(0, cursor_, 0, element.count);
  }
  /// Whether the last value that was read is the file's.
  [[nodiscard]] bool is_at_end() { return cursor_.is_at_end(); }

 private:
  PlyWrappedCursor cursor_;
};

/// The same in binary.
class PlyBinaryBody {
 public:
  using Cursor = PlyBinaryCursor;

  PlyBinaryBody(const FileBytes& file, const PlyHeader& header, std::size_t)
      : cursor_(file, header), progress_(file.progress) {}

  [[noreturn]] void fail(const std::string& what, std::int64_t index) const {
    cursor_.fail(what, index);
  }
  [[nodiscard]] std::size_t bytes_left() const { return cursor_.bytes_left(); }
  void require_room(const PlyElement& element) const;
  [[nodiscard]] std::size_t piece_count(const PlyElement& element);
  template <class Read>
  void for_pieces(const PlyElement& element, const Read& read) {
    FirstFailure failure;
    parallel_each(places_.size(), 1, [&](std::size_t piece) {
      failure.watch(piece, [&] {
        PlyBinaryCursor cursor = cursor_.behind(places_[piece]);
        const auto first = static_cast<std::int64_t>(piece) * kPieceEntries;
        const bool is_last = piece + 1 == places_.size();
        read(piece, cursor, first, is_last ? element.count : first + kPieceEntries);
        count_read(progress_, cursor_.bytes_left() - places_[piece] - cursor.bytes_left());
      });
    });
    failure.rethrow();
    cursor_ = cursor_.behind(bytes_);
  }

 private:
  static constexpr std::int64_t kPieceEntries = 4096;

  PlyBinaryCursor cursor_;
  ReadProgress* progress_;
  std::vector<std::size_t> places_;  // where each piece of the next element begins
  std::size_t bytes_ = 0;            // of the next element, where it is sound
};

}  // namespace planish
