#pragma once

#include <cstdint>
#include <vector>

#include "planish/core/error.h"
#include "planish/vulkan/embed.h"
#include "planish/vulkan/tables/instances.h"

namespace planish::vulkan {

/// Of a host's point or normal.
inline constexpr std::uint32_t kVectorBytes = 3 * sizeof(float);

/// Throws Error{InvalidArgument} with formatted() text where the condition fails.
template <class... Values>
void require_option(bool condition, FormatText<sizeof...(Values)> format, const Values&... values) {
  if (!condition) throw Error(ErrorCode::InvalidArgument, formatted(format, values...));
}

/// What a Solve has of each instance, in numbers.
struct InstanceSizes {
  std::uint64_t given, rows, points, vertices;  ///< points: of the state of level 1
  std::uint32_t max_vertex_stride;
  bool is_fair;
  bool takes_edits;   ///< the tables for them are there
  bool has_tangents;  ///< likewise
  bool has_surface;   ///< that state is there
};

/// Throws Error{InvalidArgument}.
void check_layout(const VertexLayout& layout, const InstanceSizes& sizes);

/// Every slot, the first one, too, with the strides between instances that 0 stands for. Throws
/// Error{InvalidArgument}, and Error{OutOfMemory} naming the limit that vectors of all instances
/// exceed, before any memory is taken.
[[nodiscard]] std::vector<FrameSlot> checked_slots(const Context& context,
                                                   const InstanceSizes& sizes,
                                                   const SolveOptions& options);

}  // namespace planish::vulkan
