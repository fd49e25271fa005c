// Based on: ASPRS, "LAS Specification 1.4 - R15", 2019 (and 1.2, 2008): the public header block,
// variable length records, point data record formats.
#include "planish/files/las/las_header.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>

#include "planish/core/error.h"
#include "planish/core/number_text.h"
#include "planish/files/shared/bytes.h"
#include "planish/mesh/check.h"

namespace planish {
namespace {

constexpr std::size_t kShortHeader = 227, kLongHeader = 375;  // up to 1.2, of 1.4
constexpr int kMostMinor = 4;
constexpr int kPackedFormat = 128;  // a bit that LAZ sets
constexpr int kWithheldBit = 0x80, kWideWithheldBit = 0x04;
constexpr int kLowNoise = 7, kHighNoise = 18;

struct RecordLayout {
  std::size_t bytes, color_begin;
};
// By point format.
constexpr std::array kLayouts{RecordLayout{20, 0},  RecordLayout{28, 0},  RecordLayout{26, 20},
                              RecordLayout{34, 28}, RecordLayout{57, 0},  RecordLayout{63, 28},
                              RecordLayout{30, 0},  RecordLayout{36, 30}, RecordLayout{38, 30},
                              RecordLayout{59, 0},  RecordLayout{67, 30}};

// Of fixed length, ended by a zero or the length.
std::string text_at(std::span<const std::byte> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return std::string(text.substr(0, text.find('\0')));
}

// GeoTIFF ends each name with a bar.
std::string first_name(const std::string& names) { return names.substr(0, names.find('|')); }

// What the records of the user "LASF_Projection" say.
struct Projection {
  std::string wkt, names;
  std::uint16_t projected = 0, geographic = 0;

  [[nodiscard]] std::string text() const {
    if (!wkt.empty()) return wkt;
    const std::uint16_t code = projected != 0 ? projected : geographic;
    if (code == 0) return names;
    return formatted("EPSG:{}{}", code, names.empty() ? "" : ", " + names);
  }
};

// GeoTIFF's keys: four numbers each, the first four count them.
void read_keys(std::span<const std::byte> bytes, Projection& projection) {
  constexpr std::uint16_t kGeographic = 2048, kProjected = 3072, kUserDefined = 32767;
  constexpr std::size_t kKeyBytes = 8;
  for (std::size_t at = kKeyBytes; at + kKeyBytes <= bytes.size(); at += kKeyBytes) {
    const auto number = [&](std::size_t i) {
      return load<std::uint16_t>(bytes.subspan(at + 2 * i));
    };
    if (number(1) != 0 || number(3) == kUserDefined) continue;  // the value stands elsewhere
    if (number(0) == kProjected) projection.projected = number(3);
    if (number(0) == kGeographic) projection.geographic = number(3);
  }
}

class HeaderReader {
 public:
  explicit HeaderReader(const FileBytes& file) : name_(file.name), bytes_(file.bytes) {}

  LasHeader read() {
    if (bytes_.size() < kShortHeader || text_at(bytes_.first(4)) != "LASF")
      fail(bytes_.size() < kShortHeader
               ? formatted("the file ends at byte {}, inside the header of a LAS, which has 227",
                           bytes_.size())
               : "is no LAS: it does not begin with LASF");
    read_version();
    read_point_format();
    read_placement();
    read_records();
    return std::move(header_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ErrorCode::UnreadableInput, name_ + ": " + what);
  }
  template <class Value>
  [[nodiscard]] Value at(std::size_t place) const {
    return load<Value>(bytes_.subspan(place));
  }

  void read_version() {
    const int major = at<std::uint8_t>(24);
    header_.minor_version = at<std::uint8_t>(25);
    if (major != 1 || header_.minor_version > kMostMinor)
      fail(
          formatted("LAS version {}.{} is not read; 1.0 to 1.4 are", major, header_.minor_version));
    header_.software = text_at(bytes_.subspan(58, 32));
    header_bytes_ = at<std::uint16_t>(94);
    header_.points_begin = at<std::uint32_t>(96);
    const std::size_t least = header_.minor_version == kMostMinor ? kLongHeader : kShortHeader;
    if (header_bytes_ < least || header_bytes_ > bytes_.size())
      fail(formatted("the header's size, {}, is not from {} to the file's, {}", header_bytes_,
                     least, bytes_.size()));
    if (header_.points_begin < header_bytes_ || header_.points_begin > bytes_.size())
      fail(
          formatted("points begin at byte {}, not between the header's end, {}, and the file's, {}",
                    header_.points_begin, header_bytes_, bytes_.size()));
  }

  void read_point_format() {
    const int format = at<std::uint8_t>(104);
    if ((format & kPackedFormat) != 0)
      fail(
          "is compressed (LAZ), which is not read; \"pdal translate FILE.laz FILE.las\" or "
          "\"laszip -i FILE.laz -o FILE.las\" unpacks it");
    if (static_cast<std::size_t>(format) >= kLayouts.size())
      fail(formatted("point data record format {} is not from 0 to 10", format));
    const RecordLayout& layout = kLayouts[format];
    header_.point_format = format;
    header_.color_begin = layout.color_begin;
    header_.record_bytes = at<std::uint16_t>(105);
    if (header_.record_bytes < layout.bytes)
      fail(formatted("points of format {} have {} bytes, and {} are promised", format, layout.bytes,
                     header_.record_bytes));
    std::uint64_t count = at<std::uint32_t>(107);
    if (header_.minor_version == kMostMinor)
      if (const auto wide = at<std::uint64_t>(247); wide != 0) count = wide;
    const std::size_t room = bytes_.size() - header_.points_begin;
    if (count > room / header_.record_bytes)
      fail(formatted("the header promises {} points of {} bytes, but only {} bytes follow", count,
                     header_.record_bytes, room));
    if (count == 0 && room >= header_.record_bytes)
      fail(formatted(
          "the header promises 0 points, but {} bytes follow, which {} points of {} bytes "
          "have; it may be of a recording that was cut off: \"lasinfo -repair\" counts "
          "them",
          room, room / header_.record_bytes, header_.record_bytes));
    if (count > std::numeric_limits<std::int32_t>::max())
      fail(formatted("{} points are more than 2^31 - 1, which is what one file may have", count));
    header_.point_count = static_cast<std::int64_t>(count);
  }

  void read_placement() {
    constexpr double kSteps = 0x1p31;
    for (int axis = 0; axis < 3; ++axis) {
      header_.scale[axis] = at<double>(131 + 8 * static_cast<std::size_t>(axis));
      header_.offset[axis] = at<double>(155 + 8 * static_cast<std::size_t>(axis));
      const double most = kSteps * std::abs(header_.scale[axis]) + std::abs(header_.offset[axis]);
      if (!(most <= kMaxCoordinate) || header_.scale[axis] == 0)
        fail(formatted("scale {} and offset {} of axis {} make no coordinates up to 1e150",
                       shortest(header_.scale[axis]), shortest(header_.offset[axis]),
                       std::string(1, "xyz"[axis])));
    }
  }

  // Between the header and the points; longer ones behind these.
  void read_records() {
    Projection projection;
    std::size_t place = header_bytes_;
    const auto count = at<std::uint32_t>(100);
    for (std::uint32_t i = 0; i < count; ++i)
      if (!read_record(place, header_.points_begin, false, projection)) break;
    if (header_.minor_version == kMostMinor) {
      const auto begin = at<std::uint64_t>(235);
      const auto long_count = at<std::uint32_t>(243);
      place = begin <= bytes_.size() ? static_cast<std::size_t>(begin) : bytes_.size();
      for (std::uint32_t i = 0; i < long_count; ++i)
        if (!read_record(place, bytes_.size(), true, projection)) break;
    }
    header_.coordinate_system = projection.text();
  }

  // Moves behind the record; false where it does not end before `end`.
  bool read_record(std::size_t& place, std::size_t end, bool is_long, Projection& projection) {
    const std::size_t head = is_long ? 60 : 54;
    const auto note = [&](const std::string& what) {
      header_.record_damage = formatted("the variable length record at byte {}{}", place, what);
      return false;
    };
    if (end - place < head) return note(" ends behind the room for it");
    const auto record = bytes_.subspan(place, head);
    const std::uint64_t size =
        is_long ? load<std::uint64_t>(record.subspan(20)) : load<std::uint16_t>(record.subspan(20));
    if (size > end - place - head)
      return note(formatted(" of {} bytes ends behind the room for it", size));
    const auto content = bytes_.subspan(place + head, static_cast<std::size_t>(size));
    place += head + content.size();
    if (text_at(record.subspan(2, 16)) != "LASF_Projection") return true;
    constexpr std::uint16_t kWkt = 2112, kKeys = 34735, kNames = 34737;
    const auto id = load<std::uint16_t>(record.subspan(18));
    if (id == kWkt) projection.wkt = text_at(content);
    if (id == kKeys) read_keys(content, projection);
    if (id == kNames) projection.names = first_name(text_at(content));
    return true;
  }

  std::string name_;
  std::span<const std::byte> bytes_;
  std::size_t header_bytes_ = 0;
  LasHeader header_;
};

}  // namespace

LasHeader read_las_header(const FileBytes& file) { return HeaderReader(file).read(); }

glm::dvec3 LasRecord::position() const {
  const auto steps = [&](std::size_t axis) {
    return static_cast<double>(load<std::int32_t>(bytes_.subspan(4 * axis)));
  };
  return glm::dvec3(steps(0), steps(1), steps(2)) * header_.scale + header_.offset;
}

bool LasRecord::has_place() const {
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (load<std::int32_t>(bytes_.subspan(4 * axis)) == std::numeric_limits<std::int32_t>::min())
      return false;
  return true;
}

int LasRecord::classification() const {
  if (header_.has_wide_records()) return std::to_integer<int>(bytes_[16]);
  return std::to_integer<int>(bytes_[15]) & 0x1f;
}

bool LasRecord::is_withheld() const {
  const int bit = header_.has_wide_records() ? kWideWithheldBit : kWithheldBit;
  return (std::to_integer<int>(bytes_[15]) & bit) != 0;
}

bool LasRecord::is_left_out() const {
  const int kind = classification();
  return is_withheld() || kind == kLowNoise || (kind == kHighNoise && header_.has_wide_records());
}

std::uint16_t LasRecord::source() const {
  return load<std::uint16_t>(bytes_.subspan(header_.has_wide_records() ? 20 : 18));
}

std::uint16_t LasRecord::intensity() const { return load<std::uint16_t>(bytes_.subspan(12)); }

std::uint16_t LasRecord::color(int channel) const {
  return load<std::uint16_t>(
      bytes_.subspan(header_.color_begin + 2 * static_cast<std::size_t>(channel)));
}

}  // namespace planish
