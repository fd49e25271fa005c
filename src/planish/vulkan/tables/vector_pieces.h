#pragma once

#include <cstdint>
#include <vector>

#include "planish/vulkan/device/context.h"

namespace planish::vulkan {

/// Rows that one dispatch over vectors does. first_row is a multiple of 64.
struct VectorPiece {
  std::int32_t first_row, row_count;
  std::uint32_t first_group, group_count;  ///< work groups of 64 rows, counted over all pieces
};

/// Cuts rows into as few pieces as the device's limits allow, where the largest element that a
/// binding holds for each row has `row_bytes`.
[[nodiscard]] std::vector<VectorPiece> cut_rows(const Context& context, std::int32_t row_count,
                                                std::uint64_t row_bytes);

}  // namespace planish::vulkan
