#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/core/words.h"
#include "planish/files/mesh_file.h"
#include "planish/files/read_file.h"
#include "planish/files/shared/attributes.h"
#include "planish/files/shared/text_lines.h"

namespace planish {

enum class PlyType { Int8, UInt8, Int16, UInt16, Int32, UInt32, Float32, Float64 };
[[nodiscard]] std::size_t byte_count_of(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type;
  std::optional<PlyType> count_type;  ///< of a list
};

struct PlyElement {
  std::string name;
  std::int64_t count = 0;
  std::vector<PlyProperty> properties;

  /// The fewest bytes of one entry in a binary file: every list is empty.
  [[nodiscard]] std::size_t least_bytes() const;
  /// The bytes of every entry in a binary file but those of one list; nothing where it has another.
  [[nodiscard]] std::optional<std::size_t> fixed_bytes(const PlyProperty* besides = nullptr) const;
};

enum class PlyFormat { Text, LittleEndian, BigEndian };

struct PlyHeader {
  PlyFormat format = PlyFormat::Text;
  std::vector<PlyElement> elements;
  std::vector<std::string> comments;  ///< without the word `comment`
  LineNote unknown;                   ///< lines of unknown words that are passed over
  std::size_t byte_count = 0;         ///< of the header
  std::int64_t line_count = 0;
};

/// Throws Error{UnreadableInput} `name:line: what`.
[[nodiscard]] PlyHeader read_ply_header(const FileBytes& file);

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

/// The slot of the first further property of a vertex.
inline constexpr std::size_t kPlyFirstProperty = 12;

/// Where each property of a vertex goes.
struct PlyVertexLayout {
  /// By property: 0 to 2 the coordinates, 3 and 4 the texture coordinates, 5 to 8 the colour, 9
  /// to 11 the normal, from 12 on further properties; -1 for what is passed over.
  std::vector<int> slots;
  bool has_uvs = false, has_colors = false, has_normals = false;
  bool takes_missing = false;  ///< coordinates may be NaN
  char missing_axis = 0;       ///< a coordinate that the element lacks, as x
  PropertyNames properties;    ///< further ones
};

[[nodiscard]] PlyVertexLayout ply_vertex_layout(const PlyElement& element);

/// Gives slots to further properties, numbers of any name that the format's convention does not
/// know: see PropertyNames.
void add_ply_properties(const PlyElement& element, PlyVertexLayout& layout);

/// The list of a face's vertices, null if it has none.
[[nodiscard]] const PlyProperty* ply_vertex_list(const PlyElement& face);

/// The list of texture coordinates of a face's corners, two numbers each; null if it has none.
[[nodiscard]] const PlyProperty* ply_texture_list(const PlyElement& face);

/// Of a colour or its alpha: integers as shares of their type's largest, floating-point numbers as
/// they are, for settle_colors().
[[nodiscard]] double ply_color(double value, PlyType type);

/// What was made the best of.
struct PlyNotes {
  LineNote excess, color, uv, property;

  void join(const PlyNotes& behind) {
    excess.join(behind.excess);
    color.join(behind.color);
    uv.join(behind.uv);
    property.join(behind.property);
  }
};

/// What a vertex has, by the slots of PlyVertexLayout.
struct PlyVertex {
  std::array<double, kPlyFirstProperty + kMaxProperties> values;  // properties: if there

  [[nodiscard]] glm::dvec3 position() const { return {values[0], values[1], values[2]}; }
  [[nodiscard]] glm::dvec2 uv() const { return {values[3], values[4]}; }  ///< NaN: none
  [[nodiscard]] glm::vec4 color() const { return {values[5], values[6], values[7], values[8]}; }
  [[nodiscard]] glm::vec3 normal() const { return {values[9], values[10], values[11]}; }
  [[nodiscard]] float property(std::size_t k) const {
    return static_cast<float>(values[kPlyFirstProperty + k]);
  }
};

/// Reads an entry of the element `vertex`. Colours that are no numbers are NaN, and noted, as
/// texture coordinates are; further properties are 0 there, and noted. Throws
/// Error{UnreadableInput} for positions that are none.
template <class Cursor>
PlyVertex read_ply_vertex(Cursor& cursor, const PlyElement& element, const PlyVertexLayout& layout,
                          std::int64_t vertex, PlyNotes& notes) {
  PlyVertex found;
  auto& values = found.values;
  std::fill_n(values.begin(), kPlyFirstProperty, 0.0);
  values[8] = 1;  // opaque
  std::optional<std::size_t> bad_uv, bad_color, bad_property;
  const auto fault = [&](std::size_t i) {
    return place_of(element, vertex) + ": " + visible(element.properties[i].name) + " is " +
           shortest(values[layout.slots[i]]);
  };
  for (std::size_t i = 0; i < layout.slots.size(); ++i) {
    const PlyProperty& property = element.properties[i];
    const int slot = layout.slots[i];
    if (slot < 0) {
      skip_ply_value(cursor, property, element, vertex);
    } else if (slot < 3) {
      values[slot] = layout.takes_missing ? cursor.any_number(property.type, element, vertex)
                                          : cursor.number(property.type, element, vertex);
      const bool is_missing = layout.takes_missing && std::isnan(values[slot]);
      if (!std::isfinite(values[slot]) && !is_missing) cursor.fail(fault(i), vertex);
    } else if (slot > 8) {
      values[slot] = cursor.number_or_nan(property.type, element, vertex);
      const bool is_property = slot >= static_cast<int>(kPlyFirstProperty);
      const bool is_good = is_property ? std::isfinite(static_cast<float>(values[slot]))
                                       : std::isfinite(values[slot]);
      if (is_good) continue;
      if (is_property && !bad_property) {
        bad_property = i;
        cursor.note(notes.property, fault(i), vertex);
      }
      values[slot] = 0;
    } else {
      values[slot] = cursor.any_number(property.type, element, vertex);
      std::optional<std::size_t>& bad = slot < 5 ? bad_uv : bad_color;
      if (!std::isfinite(values[slot])) {
        if (!bad) bad = i;
      } else if (slot >= 5) {
        values[slot] = ply_color(values[slot], property.type);
      }
    }
  }
  if (bad_color) {
    cursor.note(notes.color, fault(*bad_color), vertex);
    std::fill_n(values.begin() + 5, 4, std::numeric_limits<double>::quiet_NaN());
  }
  if (bad_uv) {
    cursor.note(notes.uv, fault(*bad_uv), vertex);
    values[3] = values[4] = std::numeric_limits<double>::quiet_NaN();
  }
  return found;
}

/// PLY 1.0, text or binary of either byte order: `x y z` of element `vertex` and the list
/// `vertex_indices` or `vertex_index` of element `face`, of any scalar type; triangle strips,
/// element `tristrips` with such a list in which -1 begins another strip. Vertices may have texture
/// coordinates (s t, u v, texture_u texture_v), faces a list `texcoord` of their corners'
/// coordinates, which counts before those; vertices may have colours (red green blue alpha, or
/// diffuse_red diffuse_green diffuse_blue: sRGB, integers as shares of their type's largest,
/// floating-point numbers as settle_colors() has them); all else is passed over, what faces have
/// and pictures that comments name with a warning, but for normals (nx ny nz) with
/// `split_normals_crease` and of vertices without faces. Without an element `face` the mesh has no
/// faces. Conditions and exceptions as read_mesh().
///
/// Read with a warning, unless the file is strict: values behind the last of a line, lines of the
/// header that begin with other words and look like no element or property, colours and texture
/// coordinates that are not finite, entries of text that go over lines where all numbers are as
/// many as wanted. Points without faces whose coordinates are NaN are counted and
/// left out, unless the file is strict. The result does not depend on `part_bytes`, of which a
/// thread reads about so many at a time of text.
[[nodiscard]] MeshFile read_ply(const FileBytes& file, std::size_t part_bytes = kTextPartBytes);

/// The elements behind the header of a binary file of another format, up to its end.
[[nodiscard]] MeshFile read_binary_ply_body(const FileBytes& file, const PlyHeader& header);

}  // namespace planish
