#pragma once

#include <cstdint>

#include "planish/vulkan/embed.h"
#include "planish/vulkan/tables/instances.h"

namespace planish::vulkan {

/// What a Solve has of each instance, in numbers.
struct InstanceSizes {
  std::uint64_t given, rows, points, vertices;  ///< points: of the state of level 1
  bool is_fair;
  bool has_surface;  ///< that state is there
};

/// The options with the strides between instances that 0 stands for. Throws
/// Error{InvalidArgument}, and Error{OutOfMemory} naming the limit that vectors of all instances
/// exceed, before any memory is taken.
[[nodiscard]] SolveOptions checked_instances(const Context& context, const InstanceSizes& sizes,
                                             const SolveOptions& options);

}  // namespace planish::vulkan
