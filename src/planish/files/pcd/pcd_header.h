#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "planish/files/shared/bytes.h"
#include "planish/files/shared/property_names.h"

namespace planish {

inline constexpr std::size_t kPcdNormal = 3, kPcdColor = 6;  ///< slots of PcdHeader::places

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

/// Sets the places of normals and colours, which are read where they are what the library writes.
void find_pcd_attributes(PcdHeader& header);

/// Any further field of one number becomes an attribute; '_' names what fills records up.
void find_further_fields(PcdHeader& header, PropertyNames& names);

/// An integer at the beginning of `bytes`. Each type becomes a double by itself: of a signed and an
/// unsigned one together C++ makes an unsigned one first.
template <class Signed>
[[nodiscard]] double load_pcd_integer(std::span<const std::byte> bytes, bool is_signed) {
  if (is_signed) return static_cast<double>(load<Signed>(bytes));
  return static_cast<double>(load<std::make_unsigned_t<Signed>>(bytes));
}

/// A value of a binary file at the beginning of `bytes`.
[[nodiscard]] inline double load_pcd_value(std::span<const std::byte> bytes,
                                           const PcdField& field) {
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

}  // namespace planish
