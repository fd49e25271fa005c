#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "planish/files/pcd/pcd_header.h"
#include "planish/files/shared/text_lines.h"
#include "planish/mesh/point_cloud.h"

namespace planish {

/// What a point has, by slot.
struct PcdRecord {
  std::array<double, kPcdColor> numbers{};
  std::uint32_t color = 0xffffffff;           // alpha, red, green, blue from the highest byte
  std::array<float, kMaxProperties> further;  // as many as the header has
};

/// Colours are packed in 32 bits, which the library also calls a float.
[[nodiscard]] inline std::uint32_t color_bits(double value, const PcdField& field) {
  if (field.type == 'F') return std::bit_cast<std::uint32_t>(static_cast<float>(value));
  return static_cast<std::uint32_t>(static_cast<std::int64_t>(value));
}

inline void store(PcdRecord& record, std::size_t slot, std::span<const std::byte> bytes,
                  const PcdField& field) {
  if (slot == kPcdColor) {
    record.color = load<std::uint32_t>(bytes);
  } else {
    record.numbers[slot] = load_pcd_value(bytes, field);
  }
}

/// What was read of a part of the points.
struct PcdPart {
  PointCloud cloud;
  LineNote no_number;  // of further fields

  /// Takes what was read behind.
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

}  // namespace planish
