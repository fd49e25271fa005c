#include "planish/vulkan/tables/vector_pieces.h"

#include <algorithm>

namespace planish::vulkan {

namespace {

constexpr std::int64_t kPieceLanes = 64;

}  // namespace

std::vector<VectorPiece> cut_rows(const Context& context, std::int32_t row_count,
                                  std::uint64_t row_bytes) {
  const auto by_range = static_cast<std::int64_t>(context.max_storage_range() / row_bytes);
  const std::int64_t most_groups = std::max<std::int64_t>(
      std::min(by_range / kPieceLanes, std::int64_t(context.max_group_count())), 1);
  std::vector<VectorPiece> pieces;
  std::uint32_t first_group = 0;
  for (std::int64_t row = 0; row < row_count; row += most_groups * kPieceLanes) {
    const std::int64_t count = std::min(most_groups * kPieceLanes, row_count - row);
    const auto groups = static_cast<std::uint32_t>((count + kPieceLanes - 1) / kPieceLanes);
    pieces.push_back(
        {static_cast<std::int32_t>(row), static_cast<std::int32_t>(count), first_group, groups});
    first_group += groups;
  }
  return pieces;
}

}  // namespace planish::vulkan
