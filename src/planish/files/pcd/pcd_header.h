#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "planish/files/shared/bytes.h"

namespace planish {

/// A field of the points of a file.
struct PcdField {
  std::string name;
  std::int64_t size = 4, count = 1;
  char type = 'F';
};

enum class PcdData { Text, Binary, Compressed };

/// What stands before the points.
struct PcdHeader {
  std::vector<PcdField> fields;
  std::int64_t width = -1, height = 1, points = -1;
  PcdData data = PcdData::Text;
  // Indices of the fields x, y, z, normal_x, normal_y, normal_z and rgb or rgba.
  std::array<std::size_t, 7> places{};

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
      for (std::size_t i = 0; i < std::min(places[slot], fields.size()); ++i)
        bytes[slot] += static_cast<std::size_t>(fields[i].size * fields[i].count);
    return bytes;
  }
};

/// A value of a binary file at the beginning of `bytes`.
[[nodiscard]] inline double load_pcd_value(std::span<const std::byte> bytes,
                                           const PcdField& field) {
  if (field.type == 'F') return field.size == 8 ? load<double>(bytes) : load<float>(bytes);
  const bool is_signed = field.type == 'I';
  switch (field.size) {
    case 1:
      return is_signed ? load<std::int8_t>(bytes) : load<std::uint8_t>(bytes);
    case 2:
      return is_signed ? load<std::int16_t>(bytes) : load<std::uint16_t>(bytes);
    case 4:
      return is_signed ? load<std::int32_t>(bytes) : load<std::uint32_t>(bytes);
    default:
      return is_signed ? static_cast<double>(load<std::int64_t>(bytes))
                       : static_cast<double>(load<std::uint64_t>(bytes));
  }
}

}  // namespace planish
