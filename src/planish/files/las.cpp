#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/core/words.h"
#include "planish/files/formats.h"
#include "planish/files/read_file.h"
#include "planish/files/readers.h"
#include "planish/files/shared/attributes.h"
#include "planish/mesh/check.h"

namespace planish {
namespace {

// The header of a LAS file. Its points are record_bytes apart, the first at points_begin, all
// within the file.
struct LasHeader {
  int minor_version = 0;
  int point_format = 0;
  std::size_t points_begin = 0;
  std::size_t record_bytes = 0;
  std::int64_t point_count = 0;
  glm::dvec3 scale{1.0}, offset{0.0};
  std::size_t color_begin = 0;  // of red in a record; 0: points have no colours
  std::string software;
  std::string coordinate_system;  // WKT, or what GeoTIFF's keys say; empty: nothing
  // Why records between header and points were not all read; empty: they were.
  std::string record_damage;

  // From point format 6 on.
  [[nodiscard]] bool has_wide_records() const { return point_format >= 6; }
};

// One point's record.
class LasRecord {
 public:
  // Of record_bytes.
  LasRecord(const LasHeader& header, std::span<const std::byte> bytes)
      : header_(header), bytes_(bytes) {}

  // As the file's scale and offset say, each axis rounded twice.
  [[nodiscard]] glm::dvec3 position() const;
  [[nodiscard]] int classification() const;
  // Marked as not to be used.
  [[nodiscard]] bool is_withheld() const;
  // Whether it has a place: no coordinate is the least 32-bit number, which stands for none.
  [[nodiscard]] bool has_place() const;
  // Withheld, or classified as noise.
  [[nodiscard]] bool is_left_out() const;
  [[nodiscard]] std::uint16_t source() const;
  // Of the returned pulse, in the scanner's own measure; 0 where it is not known.
  [[nodiscard]] std::uint16_t intensity() const;
  // 0 red, 1 green, 2 blue, as the file has them; for formats with colours.
  [[nodiscard]] std::uint16_t color(int channel) const;

 private:
  const LasHeader& header_;
  std::span<const std::byte> bytes_;
};

LasRecord las_record(const LasHeader& header, std::span<const std::byte> file_bytes,
                     std::size_t index) {
  return {header, file_bytes.subspan(header.points_begin + index * header.record_bytes,
                                     header.record_bytes)};
}

// Based on: ASPRS, "LAS Specification 1.4 - R15", 2019 (and 1.2, 2008): the public header block,
// variable length records, point data record formats.

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

// Throws Error{UnreadableInput} for what is no LAS of version 1.0 to 1.4, ends too early or is
// compressed (LAZ).
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

constexpr std::size_t kPiecePoints = 1 << 16;

// ASPRS' names, by number.
constexpr std::array<std::string_view, 23> kClassNames{"never classified",
                                                       "unclassified",
                                                       "ground",
                                                       "low vegetation",
                                                       "medium vegetation",
                                                       "high vegetation",
                                                       "building",
                                                       "low noise",
                                                       "model key point",
                                                       "water",
                                                       "rail",
                                                       "road",
                                                       "overlap",
                                                       "wire guard",
                                                       "wire conductor",
                                                       "transmission tower",
                                                       "wire connector",
                                                       "bridge deck",
                                                       "high noise",
                                                       "overhead structure",
                                                       "ignored ground",
                                                       "snow",
                                                       "temporal exclusion"};

std::string class_name(int number) {
  std::string text = std::to_string(number);
  if (static_cast<std::size_t>(number) >= kClassNames.size()) return text;
  return text + " " + std::string(kClassNames[number]);
}

// What is to be known before points are placed.
struct PieceSurvey {
  std::int64_t kept = 0, missing = 0;
  std::uint16_t brightest = 0;  // of all channels
  bool has_intensity = false;
};

class LasReader {
 public:
  explicit LasReader(const FileBytes& file)
      : file_(file),
        header_(read_las_header(file)),
        pieces_((count() + kPiecePoints - 1) / kPiecePoints) {}

  PointCloud read() {
    expect_passes(file_, 2);
    note_damage();
    look_at_pieces();
    std::vector<std::int64_t> first(pieces_.size() + 1, 0);
    std::uint16_t brightest = 0;
    bool has_intensity = false;
    for (std::size_t p = 0; p < pieces_.size(); ++p) {
      first[p + 1] = first[p] + pieces_[p].kept;
      cloud_.missing_count += pieces_[p].missing;
      brightest = std::max(brightest, pieces_[p].brightest);
      has_intensity |= pieces_[p].has_intensity;
    }
    cloud_.points.resize(static_cast<std::size_t>(first.back()));
    if (brightest > 0) cloud_.colors.resize(cloud_.points.size());
    if (has_intensity)
      cloud_.attributes.push_back(attribute_of_size("intensity", 1, cloud_.points.size()));
    const double white = brightest > 255 ? 65535 : 255;
    for_pieces([&](std::size_t piece, std::size_t begin, std::size_t end) {
      auto to = static_cast<std::size_t>(first[piece]);
      for (std::size_t i = begin; i < end; ++i) {
        const LasRecord record = las_record(header_, file_.bytes, i);
        if (record.is_left_out() || !record.has_place()) continue;
        cloud_.points[to] = record.position();
        if (brightest > 0) cloud_.colors[to] = color_of(record, white);
        if (has_intensity) cloud_.attributes[0].values[to] = record.intensity();
        ++to;
      }
    });
    warn_of_left_out();
    return std::move(cloud_);
  }

 private:
  [[nodiscard]] std::size_t count() const { return static_cast<std::size_t>(header_.point_count); }

  template <class Body>
  void for_pieces(const Body& body) const {
    parallel_each(pieces_.size(), 1, [&](std::size_t p) {
      const std::size_t last = std::min(count(), (p + 1) * kPiecePoints);
      body(p, p * kPiecePoints, last);
      count_read(file_.progress, (last - p * kPiecePoints) * header_.record_bytes);
    });
  }

  void look_at_pieces() {
    for_pieces([&](std::size_t piece, std::size_t begin, std::size_t end) {
      PieceSurvey survey;
      for (std::size_t i = begin; i < end; ++i) {
        const LasRecord record = las_record(header_, file_.bytes, i);
        if (record.is_left_out()) continue;
        if (!record.has_place()) {
          ++survey.missing;
          continue;
        }
        ++survey.kept;
        survey.has_intensity |= record.intensity() > 0;
        if (header_.color_begin == 0) continue;
        for (int channel = 0; channel < 3; ++channel)
          survey.brightest = std::max(survey.brightest, record.color(channel));
      }
      pieces_[piece] = survey;
    });
  }

  static glm::vec4 color_of(const LasRecord& record, double white) {
    return linear_of_srgb(
        glm::dvec4(record.color(0) / white, record.color(1) / white, record.color(2) / white, 1.0));
  }

  void note_damage() {
    if (header_.record_damage.empty()) return;
    const std::string what = std::string(file_.name) + ": " + header_.record_damage;
    if (file_.is_strict) throw Error(ErrorCode::UnreadableInput, what);
    cloud_.warnings.push_back(
        {.code = "damaged-record",
         .message = what + "; those from there on are passed over, points are read"});
  }

  void warn_of_left_out() {
    const std::int64_t left_out =
        header_.point_count - std::ssize(cloud_.points) - cloud_.missing_count;
    if (left_out == 0) return;
    cloud_.warnings.push_back(
        {.code = "noise-points",
         .message =
             formatted("{}: {}{} classified as noise or withheld in the file, and left out",
                       file_.name, counted(left_out, "point"), left_out == 1 ? " is" : " are"),
         .count = left_out});
  }

  FileBytes file_;
  LasHeader header_;
  std::vector<PieceSurvey> pieces_;
  PointCloud cloud_;
};

}  // namespace

PointCloud read_las(const FileBytes& file) { return LasReader(file).read(); }

ScanContents las_contents(const FileBytes& file) {
  const LasHeader header = read_las_header(file);
  std::map<int, std::int64_t> classes, sources;
  for (std::size_t i = 0; i < static_cast<std::size_t>(header.point_count); ++i) {
    if (i % kPiecePoints == 0) check_stop();
    const LasRecord record = las_record(header, file.bytes, i);
    ++classes[record.classification()];
    ++sources[record.source()];
  }
  ScanContents contents{
      .version = formatted("LAS 1.{}, point format {}, {} bytes a point", header.minor_version,
                           header.point_format, header.record_bytes),
      .software = header.software,
      .coordinate_system = header.coordinate_system,
      .scans = {},
      .classes = {}};
  for (const auto& [number, points] : classes)
    contents.classes.emplace_back(class_name(number), points);
  for (const auto& [number, points] : sources)
    contents.scans.emplace_back(formatted("source {}", number), points);
  return contents;
}

}  // namespace planish
