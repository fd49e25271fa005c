#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/words.h"
#include "planish/files/read_file.h"
#include "planish/files/readers.h"
#include "planish/files/shared/attributes.h"
#include "planish/files/shared/text_lines.h"
#include "planish/mesh/check.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {
namespace {

// Based on: the description of the LZF stream format in the manual of LibLZF, M. A. Lehmann.
// A control byte c < 32: c + 1 literal bytes follow. Otherwise a copy of earlier output: its
// length is c >> 5, or 7 plus the next byte where that is 7, plus 2; its distance is
// ((c & 31) << 8 | next byte) + 1.

// Three bytes copy at most 264.
constexpr std::size_t kMaxExpansion = 88;

}  // namespace

std::vector<std::byte> expand_lzf(std::span<const std::byte> data, std::size_t size) {
  if (size / kMaxExpansion > data.size()) return {};
  std::vector<std::byte> output;
  output.reserve(size);
  std::size_t at = 0;
  const auto has = [&](std::size_t count) { return count <= data.size() - at; };
  const auto next = [&] { return std::to_integer<std::size_t>(data[at++]); };
  while (at < data.size()) {
    const std::size_t control = next();
    if (control < 32) {
      const std::size_t count = control + 1;
      if (!has(count) || count > size - output.size()) return {};
      output.insert(output.end(), data.begin() + at, data.begin() + at + count);
      at += count;
      continue;
    }
    std::size_t count = control >> 5;
    if (!has(count == 7 ? 2 : 1)) return {};
    if (count == 7) count += next();
    count += 2;
    const std::size_t distance = ((control & 31) << 8 | next()) + 1;
    if (distance > output.size() || count > size - output.size()) return {};
    // Source and target may overlap: byte by byte.
    for (std::size_t i = 0; i < count; ++i) output.push_back(output[output.size() - distance]);
  }
  if (output.size() != size) return {};
  return output;
}

namespace {

constexpr std::size_t kPcdNormal = 3, kPcdColor = 6;  // slots of PcdHeader::places

// A field of the points of a file.
struct PcdField {
  std::string name;
  std::int64_t size = 4, count = 1;
  char type = 'F';
};

enum class PcdData { Text, Binary, Compressed };

// What stands before the points.
struct PcdHeader {
  std::vector<PcdField> fields;
  std::int64_t width = -1, height = 1, points = -1;
  PcdData data = PcdData::Text;
  // Indices of the fields x, y, z, normal_x, normal_y, normal_z and rgb or rgba.
  std::array<std::size_t, 7> places{};
  std::vector<std::size_t> further;  // of fields that become attributes

  [[nodiscard]] bool has(std::size_t slot) const { return places[slot] < fields.size(); }

  [[nodiscard]] std::int64_t record_bytes() const {
    std::int64_t bytes = 0;
    for (const PcdField& field : fields) bytes += field.size * field.count;
    return bytes;
  }
  // Bytes of a record that stand before the field of each slot.
  [[nodiscard]] std::array<std::size_t, 7> offsets() const {
    std::array<std::size_t, 7> bytes{};
    for (std::size_t slot = 0; slot < places.size(); ++slot)
      bytes[slot] = bytes_before(places[slot]);
    return bytes;
  }
  [[nodiscard]] std::size_t bytes_before(std::size_t field) const {
    std::size_t bytes = 0;
    for (std::size_t i = 0; i < std::min(field, fields.size()); ++i)
      bytes += static_cast<std::size_t>(fields[i].size * fields[i].count);
    return bytes;
  }
  // The same for further ones.
  [[nodiscard]] std::vector<std::size_t> further_offsets() const {
    std::vector<std::size_t> bytes;
    for (const std::size_t field : further) bytes.push_back(bytes_before(field));
    return bytes;
  }
};

// An integer at the beginning of `bytes`. Each type becomes a double by itself: of a signed and an
// unsigned one together C++ makes an unsigned one first.
template <class Signed>
double load_pcd_integer(std::span<const std::byte> bytes, bool is_signed) {
  if (is_signed) return static_cast<double>(load<Signed>(bytes));
  return static_cast<double>(load<std::make_unsigned_t<Signed>>(bytes));
}

// A value of a binary file at the beginning of `bytes`.
double load_pcd_value(std::span<const std::byte> bytes, const PcdField& field) {
  if (field.type == 'F') return field.size == 8 ? load<double>(bytes) : load<float>(bytes);
  const bool is_signed = field.type == 'I';
  switch (field.size) {
    case 1:
      return load_pcd_integer<std::int8_t>(bytes, is_signed);
    case 2:
      return load_pcd_integer<std::int16_t>(bytes, is_signed);
    case 4:
      return load_pcd_integer<std::int32_t>(bytes, is_signed);
    default:
      return load_pcd_integer<std::int64_t>(bytes, is_signed);
  }
}

// Sets the places of normals and colours, which are read where they are what the library writes.
void find_pcd_attributes(PcdHeader& header) {
  constexpr std::array<std::string_view, 3> kNormalNames = {"normal_x", "normal_y", "normal_z"};
  const std::size_t none = header.fields.size();
  const auto place_of = [&](std::string_view name, bool is_number) {
    const auto found = std::ranges::find(header.fields, name, &PcdField::name);
    const bool fits = found != header.fields.end() && found->count == 1 &&
                      (is_number ? found->type == 'F' && found->size >= 4 : found->size == 4);
    return fits ? static_cast<std::size_t>(found - header.fields.begin()) : none;
  };
  for (std::size_t axis = 0; axis < 3; ++axis)
    header.places[kPcdNormal + axis] = place_of(kNormalNames[axis], true);
  if (!header.has(3) || !header.has(4) || !header.has(5))
    std::fill_n(header.places.begin() + kPcdNormal, 3, none);
  const std::size_t opaque = place_of("rgb", false);
  header.places[kPcdColor] = opaque < none ? opaque : place_of("rgba", false);
}

// Any further field of one number becomes an attribute; '_' names what fills records up.
void find_further_fields(PcdHeader& header, PropertyNames& names) {
  constexpr std::array<std::string_view, 9> kKnown = {
      "x", "y", "z", "normal_x", "normal_y", "normal_z", "rgb", "rgba", "_"};
  for (std::size_t f = 0; f < header.fields.size(); ++f) {
    const PcdField& field = header.fields[f];
    const bool fits = field.count == 1 && (field.type != 'F' || field.size >= 4);
    if (fits && std::ranges::find(kKnown, field.name) == kKnown.end() && names.add(field.name))
      header.further.push_back(f);
  }
}

// What a point has, by slot.
struct PcdRecord {
  std::array<double, kPcdColor> numbers{};
  std::uint32_t color = 0xffffffff;           // alpha, red, green, blue from the highest byte
  std::array<float, kMaxProperties> further;  // as many as the header has
};

// Colours are packed in 32 bits, which the library also calls a float.
std::uint32_t color_bits(double value, const PcdField& field) {
  if (field.type == 'F') return std::bit_cast<std::uint32_t>(static_cast<float>(value));
  return static_cast<std::uint32_t>(static_cast<std::int64_t>(value));
}

void store(PcdRecord& record, std::size_t slot, std::span<const std::byte> bytes,
           const PcdField& field) {
  if (slot == kPcdColor) {
    record.color = load<std::uint32_t>(bytes);
  } else {
    record.numbers[slot] = load_pcd_value(bytes, field);
  }
}

// What was read of a part of the points.
struct PcdPart {
  PointCloud cloud;
  LineNote no_number;  // of further fields

  // Takes what was read behind.
  void append(PcdPart& behind) {
    const auto join = [](auto& to, const auto& values) {
      to.insert(to.end(), values.begin(), values.end());
    };
    join(cloud.points, behind.cloud.points);
    join(cloud.normals, behind.cloud.normals);
    join(cloud.colors, behind.cloud.colors);
    for (std::size_t k = 0; k < cloud.attributes.size(); ++k)
      join(cloud.attributes[k].values, behind.cloud.attributes[k].values);
    cloud.missing_count += behind.cloud.missing_count;
    no_number.join(behind.no_number);
    behind = {};
  }
};

// Based on: "The PCD (Point Cloud Data) file format", documentation of the Point Cloud Library.

constexpr std::int64_t kMaxPoints = std::numeric_limits<std::int32_t>::max();
// PCL's own limit on a field's count is smaller; this keeps sums of sizes within 64 bits.
constexpr std::int64_t kMaxFieldCount = 1 << 20;
// Times kMaxPoints it stays within 64 bits.
constexpr std::int64_t kMaxRecordBytes = 1 << 30;

class PcdReader {
 public:
  PcdReader(const FileBytes& file, std::size_t part_bytes)
      : file_(file),
        name_(file.name),
        lines_(TextLines::of_header(file)),
        part_bytes_(part_bytes) {}

  PointCloud read() {
    read_header();
    switch (header_.data) {
      case PcdData::Text:
        read_text();
        break;
      case PcdData::Binary:
        read_binary();
        break;
      case PcdData::Compressed:
        read_compressed();
        break;
    }
    PointCloud& cloud = read_.cloud;
    unknown_.warn(cloud.warnings, "unknown-keyword", name_, "such lines are passed over");
    properties_.warn(cloud.warnings, name_, "points");
    read_.no_number.warn(cloud.warnings, "missing-properties", name_,
                         "such properties are 0 there");
    return std::move(cloud);
  }

 private:
  void read_header();
  void read_header_line(std::string_view keyword, Words words);
  void pass_over(std::string_view keyword, Words words);
  template <class Set>
  void for_each_field(Words words, std::string_view keyword, const Set& set);
  std::int64_t read_count(std::string_view keyword, std::string_view word, std::int64_t most);
  void check_header();
  void set_word(PcdRecord& record, std::size_t slot, std::string_view word, const TextLines& line,
                std::int64_t index) const;
  PcdRecord record_of(const TextLines& line, std::int64_t index) const;
  void read_text();
  void read_binary();
  void read_compressed();
  [[nodiscard]] PcdPart empty_part() const;
  void add(const PcdRecord& record, std::int64_t index, PcdPart& part, const TextLines* line) const;
  void add_further(const PcdRecord& record, std::int64_t index, PcdPart& part,
                   const TextLines* line) const;
  void add_next(const PcdRecord& record, std::int64_t index);
  [[noreturn]] void fail(const std::string& what, std::int64_t element = -1) const {
    throw Error(ErrorCode::UnreadableInput, name_ + ": " + what, element);
  }

  FileBytes file_;
  std::string name_;
  TextLines lines_;
  std::size_t part_bytes_;
  LineNote unknown_;
  PcdHeader header_;
  PropertyNames properties_;  // of the header's further fields
  PcdPart read_;
};

std::int64_t PcdReader::read_count(std::string_view keyword, std::string_view word,
                                   std::int64_t most) {
  std::int64_t value = 0;
  if (!parse_integer(word, value) || value < 0 || value > most)
    lines_.fail(formatted("{} {} is no integer from 0 to {}", keyword, quote(word), most));
  return value;
}

template <class Set>
void PcdReader::for_each_field(Words words, std::string_view keyword, const Set& set) {
  for (PcdField& field : header_.fields) {
    const std::string_view word = words.next();
    if (word.empty()) lines_.fail(std::string(keyword) + " names fewer values than FIELDS");
    set(field, word);
  }
  if (!words.next().empty()) lines_.fail(std::string(keyword) + " names more values than FIELDS");
}

void PcdReader::read_header_line(std::string_view keyword, Words words) {
  if (keyword == "FIELDS" || keyword == "COLUMNS") {
    for (std::string_view word = words.next(); !word.empty(); word = words.next())
      header_.fields.push_back({.name = std::string(word)});
  } else if (keyword == "SIZE") {
    for_each_field(words, keyword, [&](PcdField& field, std::string_view word) {
      field.size = read_count(keyword, word, 8);
      if (!std::has_single_bit(static_cast<std::uint64_t>(field.size)))
        lines_.fail("SIZE " + quote(word) + " is not 1, 2, 4 or 8");
    });
  } else if (keyword == "TYPE") {
    for_each_field(words, keyword, [&](PcdField& field, std::string_view word) {
      if (word != "F" && word != "I" && word != "U")
        lines_.fail("TYPE " + quote(word) + " is not F, I or U");
      field.type = word.front();
    });
  } else if (keyword == "COUNT") {
    for_each_field(words, keyword, [&](PcdField& field, std::string_view word) {
      field.count = read_count(keyword, word, kMaxFieldCount);
    });
  } else if (keyword == "WIDTH") {
    header_.width = read_count(keyword, words.next(), kMaxPoints);
  } else if (keyword == "HEIGHT") {
    header_.height = read_count(keyword, words.next(), kMaxPoints);
  } else if (keyword == "POINTS") {
    header_.points = read_count(keyword, words.next(), kMaxPoints);
  } else if (keyword != "VERSION" && keyword != "VIEWPOINT") {
    pass_over(keyword, words);
  }
}

// A line that may be a misspelt count, or sizes of the fields, on which the places of all values
// depend, cannot be passed over.
void PcdReader::pass_over(std::string_view keyword, Words words) {
  const std::string what = "unknown keyword " + quote(keyword) + "; is this a PCD file?";
  std::size_t count = 0;
  while (!words.next().empty()) ++count;
  if (count == 1 || count == header_.fields.size()) lines_.fail(what);
  lines_.note(unknown_, what);
}

void PcdReader::read_header() {
  while (lines_.next_with_words()) {
    Words words(lines_.line());
    const std::string_view keyword = words.next();
    if (keyword != "DATA") {
      read_header_line(keyword, words);
      continue;
    }
    const std::string_view kind = words.next();
    if (kind == "ascii") {
      header_.data = PcdData::Text;
    } else if (kind == "binary") {
      header_.data = PcdData::Binary;
    } else if (kind == "binary_compressed") {
      header_.data = PcdData::Compressed;
    } else {
      lines_.fail("DATA " + quote(kind) + " is not ascii, binary or binary_compressed");
    }
    check_header();
    return;
  }
  fail("the file ends before the line DATA");
}

void PcdReader::check_header() {
  constexpr std::array<std::string_view, 3> kAxes = {"x", "y", "z"};
  for (int axis = 0; axis < 3; ++axis) {
    const auto found = std::ranges::find(header_.fields, kAxes[axis], &PcdField::name);
    if (found == header_.fields.end())
      lines_.fail("FIELDS has no " + quote(kAxes[axis]) + "; x, y and z are needed");
    if (found->count != 1) lines_.fail("COUNT of " + quote(kAxes[axis]) + " is not 1");
    if (found->type == 'F' && found->size < 4)
      lines_.fail("SIZE of " + quote(kAxes[axis]) + " is no 4 or 8, as type F needs");
    header_.places[axis] = static_cast<std::size_t>(found - header_.fields.begin());
  }
  find_pcd_attributes(header_);
  find_further_fields(header_, properties_);
  read_ = empty_part();
  if (header_.record_bytes() > kMaxRecordBytes) lines_.fail("a point has more than 2^30 bytes");
  if (header_.width < 0 && header_.points < 0) lines_.fail("neither WIDTH nor POINTS is given");
  // Both factors are below 2^31.
  const std::int64_t product = header_.width < 0 ? header_.points : header_.width * header_.height;
  if (header_.points < 0) header_.points = product;
  if (header_.points != product || product > kMaxPoints)
    lines_.fail(formatted("POINTS {} is not WIDTH times HEIGHT, {}", header_.points, product));
}

PcdPart PcdReader::empty_part() const {
  PcdPart part;
  for (const std::string& name : properties_.names())
    part.cloud.attributes.push_back(attribute_of_size(name, 1, 0));
  return part;
}

void PcdReader::add_further(const PcdRecord& record, std::int64_t index, PcdPart& part,
                            const TextLines* line) const {
  bool is_noted = false;
  for (std::size_t k = 0; k < header_.further.size(); ++k) {
    float value = record.further[k];
    if (!std::isfinite(value)) {
      const std::string what =
          formatted("point {}: {} is {}", index, visible(header_.fields[header_.further[k]].name),
                    shortest(value));
      if (line != nullptr && !is_noted) line->note(part.no_number, what, index);
      if (line == nullptr && !is_noted) {
        if (file_.is_strict) fail(what, index);
        part.no_number.add(0, what, index);
      }
      is_noted = true;
      value = 0;
    }
    part.cloud.attributes[k].values.push_back(value);
  }
}

// `line`: of text.
void PcdReader::add(const PcdRecord& record, std::int64_t index, PcdPart& part,
                    const TextLines* line) const {
  PointCloud& cloud = part.cloud;
  const glm::dvec3 point(record.numbers[0], record.numbers[1], record.numbers[2]);
  for (int axis = 0; axis < 3; ++axis) {
    if (std::isnan(point[axis])) {
      ++cloud.missing_count;
      return;
    }
    if (std::abs(point[axis]) > kMaxCoordinate)
      fail(formatted("point {} of {} has a coordinate beyond 1e150", index, header_.points), index);
  }
  cloud.points.push_back(point);
  add_further(record, index, part, line);
  if (header_.has(kPcdNormal))
    cloud.normals.emplace_back(record.numbers[3], record.numbers[4], record.numbers[5]);
  if (!header_.has(kPcdColor)) return;
  const auto share = [&](int shift) { return (record.color >> shift & 0xff) / 255.0; };
  const bool is_opaque = header_.fields[header_.places[kPcdColor]].name == "rgb";
  cloud.colors.push_back(
      linear_of_srgb(glm::dvec4(share(16), share(8), share(0), is_opaque ? 1.0 : share(24))));
}

// Of points one after another.
void PcdReader::add_next(const PcdRecord& record, std::int64_t index) {
  constexpr std::size_t kPiece = 4096;
  add(record, index, read_, nullptr);
  if (static_cast<std::size_t>(index + 1) % kPiece != 0) return;
  check_stop();
  count_read(file_.progress,
             file_.bytes.size() * kPiece / static_cast<std::size_t>(header_.points));
}

void PcdReader::set_word(PcdRecord& record, std::size_t slot, std::string_view word,
                         const TextLines& line, std::int64_t index) const {
  double value = 0;
  if (!parse_number(word, value)) {
    if (slot < kPcdNormal && !is_nan_word(word))
      line.fail("coordinate " + no_finite_number(word), index);
    value = std::numeric_limits<double>::quiet_NaN();
  }
  if (slot < kPcdColor) {
    record.numbers[slot] = value;
  } else if (std::abs(value) < 0x1p63) {  // not for a NaN
    record.color = color_bits(value, header_.fields[header_.places[slot]]);
  }
}

void PcdReader::read_text() {
  if (static_cast<std::uint64_t>(header_.points) > (lines_.bytes_left() + 1) / 6)
    lines_.fail(formatted("POINTS promises {}, but only {} bytes follow", header_.points,
                          lines_.bytes_left()));
  FileBytes body = file_;
  body.bytes = file_.bytes.last(lines_.bytes_left());
  TextLines lines(body);
  lines.count_from(lines_.number());
  const LineRecords records(body, lines, part_bytes_);
  std::vector<PcdPart> parts(records.part_count(), empty_part());
  records.for_parts(0, header_.points, "point",
                    [&](std::size_t part, TextLines& line, std::int64_t begin, std::int64_t end) {
                      for (std::int64_t i = begin; i < end && line.next_with_words(); ++i)
                        add(record_of(line, i), i, parts[part], &line);
                    });
  for (PcdPart& part : parts) read_.append(part);
}

// What a line of text says.
PcdRecord PcdReader::record_of(const TextLines& line, std::int64_t index) const {
  Words words(line.line());
  PcdRecord record;
  for (std::size_t f = 0; f < header_.fields.size(); ++f) {
    std::string_view word;
    for (std::int64_t i = 0; i < header_.fields[f].count; ++i) {
      word = words.next();
      if (word.empty()) line.fail(formatted("point {} has too few values", index));
    }
    const auto slot = std::ranges::find(header_.places, f) - header_.places.begin();
    if (slot <= static_cast<std::ptrdiff_t>(kPcdColor))
      set_word(record, static_cast<std::size_t>(slot), word, line, index);
    const auto further = std::ranges::find(header_.further, f) - header_.further.begin();
    if (further == std::ssize(header_.further)) continue;
    double value = 0;
    record.further[further] = parse_number(word, value) ? static_cast<float>(value)
                                                        : std::numeric_limits<float>::quiet_NaN();
  }
  return record;
}

void PcdReader::read_binary() {
  const std::span<const std::byte> body = file_.bytes.last(lines_.bytes_left());
  const std::int64_t stride = header_.record_bytes();
  if (static_cast<std::uint64_t>(header_.points) > body.size() / static_cast<std::size_t>(stride))
    fail(formatted("POINTS promises {} points of {} bytes, but only {} bytes follow",
                   header_.points, stride, body.size()));
  read_.cloud.points.reserve(header_.points);
  const std::array<std::size_t, kPcdColor + 1> offsets = header_.offsets();
  const std::vector<std::size_t> further = header_.further_offsets();
  for (std::int64_t index = 0; index < header_.points; ++index) {
    const auto record = body.subspan(index * stride, stride);
    PcdRecord found;
    for (std::size_t slot = 0; slot <= kPcdColor; ++slot)
      if (header_.has(slot))
        store(found, slot, record.subspan(offsets[slot]), header_.fields[header_.places[slot]]);
    for (std::size_t k = 0; k < further.size(); ++k)
      found.further[k] = static_cast<float>(
          load_pcd_value(record.subspan(further[k]), header_.fields[header_.further[k]]));
    add_next(found, index);
  }
}

void PcdReader::read_compressed() {
  constexpr std::size_t kSizes = 8;
  const std::span<const std::byte> body = file_.bytes.last(lines_.bytes_left());
  if (body.size() < kSizes) fail("the file ends inside the sizes of its compressed data");
  const std::size_t packed = load<std::uint32_t>(body);
  const std::size_t expanded = load<std::uint32_t>(body.subspan(4));
  if (packed > body.size() - kSizes)
    fail(formatted("compressed data of {} bytes is promised, but only {} bytes follow", packed,
                   body.size() - kSizes));
  if (header_.points * header_.record_bytes() != static_cast<std::int64_t>(expanded))
    fail(formatted("compressed data expands to {} bytes, but {} points of {} bytes are promised",
                   expanded, header_.points, header_.record_bytes()));
  const auto count = static_cast<std::size_t>(header_.points);
  const std::vector<std::byte> data = expand_lzf(body.subspan(kSizes, packed), expanded);
  if (data.size() != expanded) fail("the compressed data is damaged");
  // Unlike the other kinds, all values of a field stand together.
  read_.cloud.points.reserve(count);
  const std::array<std::size_t, kPcdColor + 1> offsets = header_.offsets();
  const std::vector<std::size_t> further = header_.further_offsets();
  for (std::size_t index = 0; index < count; ++index) {
    PcdRecord record;
    for (std::size_t slot = 0; slot <= kPcdColor; ++slot) {
      if (!header_.has(slot)) continue;
      const PcdField& field = header_.fields[header_.places[slot]];
      store(record, slot, std::span(data).subspan(offsets[slot] * count + index * field.size),
            field);
    }
    for (std::size_t k = 0; k < further.size(); ++k) {
      const PcdField& field = header_.fields[header_.further[k]];
      record.further[k] = static_cast<float>(
          load_pcd_value(std::span(data).subspan(further[k] * count + index * field.size), field));
    }
    add_next(record, static_cast<std::int64_t>(index));
  }
}

}  // namespace

PointCloud read_pcd(const FileBytes& file, std::size_t part_bytes) {
  return PcdReader(file, part_bytes).read();
}

}  // namespace planish
