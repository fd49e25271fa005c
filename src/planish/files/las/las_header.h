#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <string>

#include "planish/files/formats.h"

namespace planish {

/// The header of a LAS file. Its points are record_bytes apart, the first at points_begin, all
/// within the file.
struct LasHeader {
  int minor_version = 0;
  int point_format = 0;
  std::size_t points_begin = 0;
  std::size_t record_bytes = 0;
  std::int64_t point_count = 0;
  glm::dvec3 scale{1.0}, offset{0.0};
  std::size_t color_begin = 0;  ///< of red in a record; 0: points have no colours
  std::string software;
  std::string coordinate_system;  ///< WKT, or what GeoTIFF's keys say; empty: nothing
  /// Why records between header and points were not all read; empty: they were.
  std::string record_damage;

  /// From point format 6 on.
  [[nodiscard]] bool has_wide_records() const { return point_format >= 6; }
};

/// Throws Error{UnreadableInput} for what is no LAS of version 1.0 to 1.4, ends too early or is
/// compressed (LAZ).
[[nodiscard]] LasHeader read_las_header(const FileBytes& file);

/// One point's record.
class LasRecord {
 public:
  /// Of record_bytes.
  LasRecord(const LasHeader& header, std::span<const std::byte> bytes)
      : header_(header), bytes_(bytes) {}

  /// As the file's scale and offset say, each axis rounded twice.
  [[nodiscard]] glm::dvec3 position() const;
  [[nodiscard]] int classification() const;
  /// Marked as not to be used.
  [[nodiscard]] bool is_withheld() const;
  /// Whether it has a place: no coordinate is the least 32-bit number, which stands for none.
  [[nodiscard]] bool has_place() const;
  /// Withheld, or classified as noise.
  [[nodiscard]] bool is_left_out() const;
  [[nodiscard]] std::uint16_t source() const;
  /// Of the returned pulse, in the scanner's own measure; 0 where it is not known.
  [[nodiscard]] std::uint16_t intensity() const;
  /// 0 red, 1 green, 2 blue, as the file has them; for formats with colours.
  [[nodiscard]] std::uint16_t color(int channel) const;

 private:
  const LasHeader& header_;
  std::span<const std::byte> bytes_;
};

[[nodiscard]] inline LasRecord las_record(const LasHeader& header,
                                          std::span<const std::byte> file_bytes,
                                          std::size_t index) {
  return {header, file_bytes.subspan(header.points_begin + index * header.record_bytes,
                                     header.record_bytes)};
}

}  // namespace planish
