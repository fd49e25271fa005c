// Based on: "The PCD (Point Cloud Data) file format", documentation of the Point Cloud Library.
#include "planish/files/pcd/read_pcd.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/number_text.h"
#include "planish/core/stop.h"
#include "planish/files/pcd/lzf.h"
#include "planish/files/pcd/pcd_header.h"
#include "planish/files/shared/bytes.h"
#include "planish/files/shared/line_records.h"
#include "planish/files/shared/read_progress.h"
#include "planish/files/shared/srgb.h"
#include "planish/mesh/check.h"

namespace planish {
namespace {

constexpr std::int64_t kMaxPoints = std::numeric_limits<std::int32_t>::max();
// PCL's own limit on a field's count is smaller; this keeps sums of sizes within 64 bits.
constexpr std::int64_t kMaxFieldCount = 1 << 20;
// Times kMaxPoints it stays within 64 bits.
constexpr std::int64_t kMaxRecordBytes = 1 << 30;

constexpr std::size_t kNormal = 3, kColor = 6;  // slots of PcdHeader::places

// What a point has, by slot.
struct Record {
  std::array<double, kColor> numbers{};
  std::uint32_t color = 0xffffffff;  // alpha, red, green, blue from the highest byte
};

// Colours are packed in 32 bits, which the library also calls a float.
std::uint32_t color_bits(double value, const PcdField& field) {
  if (field.type == 'F') return std::bit_cast<std::uint32_t>(static_cast<float>(value));
  return static_cast<std::uint32_t>(static_cast<std::int64_t>(value));
}

void store(Record& record, std::size_t slot, std::span<const std::byte> bytes,
           const PcdField& field) {
  if (slot == kColor) {
    record.color = load<std::uint32_t>(bytes);
  } else {
    record.numbers[slot] = load_pcd_value(bytes, field);
  }
}

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
    unknown_.warn(cloud_.warnings, "unknown-keyword", name_, "such lines are passed over");
    return std::move(cloud_);
  }

 private:
  void read_header();
  void read_header_line(std::string_view keyword, Words words);
  void pass_over(std::string_view keyword, Words words);
  template <class Set>
  void for_each_field(Words words, std::string_view keyword, const Set& set);
  std::int64_t read_count(std::string_view keyword, std::string_view word, std::int64_t most);
  void check_header();
  void find_attributes();
  void set_word(Record& record, std::size_t slot, std::string_view word, const TextLines& line,
                std::int64_t index) const;
  Record record_of(const TextLines& line, std::int64_t index) const;
  void read_text();
  void read_binary();
  void read_compressed();
  void add(const Record& record, std::int64_t index, PointCloud& cloud) const;
  void add_next(const Record& record, std::int64_t index);
  [[noreturn]] void fail(const std::string& what, std::int64_t element = -1) const {
    throw Error(ErrorCode::UnreadableInput, name_ + ": " + what, element);
  }

  FileBytes file_;
  std::string name_;
  TextLines lines_;
  std::size_t part_bytes_;
  LineNote unknown_;
  PcdHeader header_;
  PointCloud cloud_;
};

std::int64_t PcdReader::read_count(std::string_view keyword, std::string_view word,
                                   std::int64_t most) {
  std::int64_t value = 0;
  if (!parse_integer(word, value) || value < 0 || value > most)
    lines_.fail(std::string(keyword) + " " + quote(word) + " is no integer from 0 to " +
                std::to_string(most));
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
  find_attributes();
  if (header_.record_bytes() > kMaxRecordBytes) lines_.fail("a point has more than 2^30 bytes");
  if (header_.width < 0 && header_.points < 0) lines_.fail("neither WIDTH nor POINTS is given");
  // Both factors are below 2^31.
  const std::int64_t product = header_.width < 0 ? header_.points : header_.width * header_.height;
  if (header_.points < 0) header_.points = product;
  if (header_.points != product || product > kMaxPoints)
    lines_.fail("POINTS " + std::to_string(header_.points) + " is not WIDTH times HEIGHT, " +
                std::to_string(product));
}

// Normals and colours are read where they are what the library writes.
void PcdReader::find_attributes() {
  constexpr std::array<std::string_view, 3> kNormals = {"normal_x", "normal_y", "normal_z"};
  const std::size_t none = header_.fields.size();
  const auto place_of = [&](std::string_view name, bool is_number) {
    const auto found = std::ranges::find(header_.fields, name, &PcdField::name);
    const bool fits = found != header_.fields.end() && found->count == 1 &&
                      (is_number ? found->type == 'F' && found->size >= 4 : found->size == 4);
    return fits ? static_cast<std::size_t>(found - header_.fields.begin()) : none;
  };
  for (std::size_t axis = 0; axis < 3; ++axis)
    header_.places[kNormal + axis] = place_of(kNormals[axis], true);
  if (!header_.has(3) || !header_.has(4) || !header_.has(5))
    std::fill_n(header_.places.begin() + kNormal, 3, none);
  const std::size_t opaque = place_of("rgb", false);
  header_.places[kColor] = opaque < none ? opaque : place_of("rgba", false);
}

void PcdReader::add(const Record& record, std::int64_t index, PointCloud& cloud) const {
  const glm::dvec3 point(record.numbers[0], record.numbers[1], record.numbers[2]);
  for (int axis = 0; axis < 3; ++axis) {
    if (std::isnan(point[axis])) {
      ++cloud.missing_count;
      return;
    }
    if (std::abs(point[axis]) > kMaxCoordinate)
      fail("point " + std::to_string(index) + " of " + std::to_string(header_.points) +
               " has a coordinate beyond 1e150",
           index);
  }
  cloud.points.push_back(point);
  if (header_.has(kNormal))
    cloud.normals.emplace_back(record.numbers[3], record.numbers[4], record.numbers[5]);
  if (!header_.has(kColor)) return;
  const auto share = [&](int shift) { return (record.color >> shift & 0xff) / 255.0; };
  const bool is_opaque = header_.fields[header_.places[kColor]].name == "rgb";
  cloud.colors.push_back(
      linear_of_srgb(glm::dvec4(share(16), share(8), share(0), is_opaque ? 1.0 : share(24))));
}

// Of points one after another.
void PcdReader::add_next(const Record& record, std::int64_t index) {
  constexpr std::size_t kPiece = 4096;
  add(record, index, cloud_);
  if (static_cast<std::size_t>(index + 1) % kPiece != 0) return;
  check_stop();
  count_read(file_.progress,
             file_.bytes.size() * kPiece / static_cast<std::size_t>(header_.points));
}

void PcdReader::set_word(Record& record, std::size_t slot, std::string_view word,
                         const TextLines& line, std::int64_t index) const {
  double value = 0;
  if (!parse_number(word, value)) {
    if (slot < kNormal && !is_nan_word(word))
      line.fail("coordinate " + no_finite_number(word), index);
    value = std::numeric_limits<double>::quiet_NaN();
  }
  if (slot < kColor) {
    record.numbers[slot] = value;
  } else if (std::abs(value) < 0x1p63) {  // not for a NaN
    record.color = color_bits(value, header_.fields[header_.places[slot]]);
  }
}

void PcdReader::read_text() {
  if (static_cast<std::uint64_t>(header_.points) > (lines_.bytes_left() + 1) / 6)
    lines_.fail("POINTS promises " + std::to_string(header_.points) + ", but only " +
                std::to_string(lines_.bytes_left()) + " bytes follow");
  FileBytes body = file_;
  body.bytes = file_.bytes.last(lines_.bytes_left());
  TextLines lines(body);
  lines.count_from(lines_.number());
  const LineRecords records(body, lines, part_bytes_);
  std::vector<PointCloud> clouds(records.part_count());
  records.for_parts(0, header_.points, "point",
                    [&](std::size_t part, TextLines& line, std::int64_t begin, std::int64_t end) {
                      for (std::int64_t i = begin; i < end && line.next_with_words(); ++i)
                        add(record_of(line, i), i, clouds[part]);
                    });
  const auto append = [](auto& to, const auto& values) {
    to.insert(to.end(), values.begin(), values.end());
  };
  for (PointCloud& cloud : clouds) {
    append(cloud_.points, cloud.points);
    append(cloud_.normals, cloud.normals);
    append(cloud_.colors, cloud.colors);
    cloud_.missing_count += cloud.missing_count;
    cloud = {};
  }
}

// What a line of text says.
Record PcdReader::record_of(const TextLines& line, std::int64_t index) const {
  Words words(line.line());
  Record record;
  for (std::size_t f = 0; f < header_.fields.size(); ++f) {
    std::string_view word;
    for (std::int64_t i = 0; i < header_.fields[f].count; ++i) {
      word = words.next();
      if (word.empty()) line.fail("point " + std::to_string(index) + " has too few values");
    }
    const auto slot = std::ranges::find(header_.places, f) - header_.places.begin();
    if (slot <= static_cast<std::ptrdiff_t>(kColor))
      set_word(record, static_cast<std::size_t>(slot), word, line, index);
  }
  return record;
}

void PcdReader::read_binary() {
  const std::span<const std::byte> body = file_.bytes.last(lines_.bytes_left());
  const std::int64_t stride = header_.record_bytes();
  if (static_cast<std::uint64_t>(header_.points) > body.size() / static_cast<std::size_t>(stride))
    fail("POINTS promises " + std::to_string(header_.points) + " points of " +
         std::to_string(stride) + " bytes, but only " + std::to_string(body.size()) +
         " bytes follow");
  cloud_.points.reserve(header_.points);
  const std::array<std::size_t, kColor + 1> offsets = header_.offsets();
  for (std::int64_t index = 0; index < header_.points; ++index) {
    const auto record = body.subspan(index * stride, stride);
    Record found;
    for (std::size_t slot = 0; slot <= kColor; ++slot)
      if (header_.has(slot))
        store(found, slot, record.subspan(offsets[slot]), header_.fields[header_.places[slot]]);
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
    fail("compressed data of " + std::to_string(packed) + " bytes is promised, but only " +
         std::to_string(body.size() - kSizes) + " bytes follow");
  const auto count = static_cast<std::size_t>(header_.points);
  if (count * static_cast<std::size_t>(header_.record_bytes()) != expanded)
    fail("compressed data expands to " + std::to_string(expanded) + " bytes, but " +
         std::to_string(count) + " points of " + std::to_string(header_.record_bytes()) +
         " bytes are promised");
  const std::vector<std::byte> data = expand_lzf(body.subspan(kSizes, packed), expanded);
  if (data.size() != expanded) fail("the compressed data is damaged");
  // Unlike the other kinds, all values of a field stand together.
  cloud_.points.reserve(count);
  const std::array<std::size_t, kColor + 1> offsets = header_.offsets();
  for (std::size_t index = 0; index < count; ++index) {
    Record record;
    for (std::size_t slot = 0; slot <= kColor; ++slot) {
      if (!header_.has(slot)) continue;
      const PcdField& field = header_.fields[header_.places[slot]];
      store(record, slot, std::span(data).subspan(offsets[slot] * count + index * field.size),
            field);
    }
    add_next(record, static_cast<std::int64_t>(index));
  }
}

}  // namespace

PointCloud read_pcd(const FileBytes& file, std::size_t part_bytes) {
  return PcdReader(file, part_bytes).read();
}

}  // namespace planish
