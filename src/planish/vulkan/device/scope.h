#pragma once

#include "planish/vulkan/device/functions.h"

namespace planish::vulkan {

/// Stages and accesses on one side of a barrier.
struct Scope {
  VkPipelineStageFlags stages;
  VkAccessFlags accesses;
};

inline constexpr Scope kKernelScope{VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                                    VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT};
inline constexpr Scope kCopyScope{VK_PIPELINE_STAGE_TRANSFER_BIT,
                                  VK_ACCESS_TRANSFER_READ_BIT | VK_ACCESS_TRANSFER_WRITE_BIT};
inline constexpr Scope kIndirectScope{VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT | kKernelScope.stages,
                                      VK_ACCESS_INDIRECT_COMMAND_READ_BIT | kKernelScope.accesses};
/// Everything that a record_ function does; what a host's own barriers pair with. Before: from what
/// the host did to kEntryScope. After: from kExitScope to what the host does next.
inline constexpr Scope kEntryScope{kIndirectScope.stages | kCopyScope.stages,
                                   kIndirectScope.accesses | kCopyScope.accesses};
inline constexpr Scope kExitScope = kEntryScope;
inline constexpr Scope kHostReadScope{VK_PIPELINE_STAGE_HOST_BIT, VK_ACCESS_HOST_READ_BIT};

}  // namespace planish::vulkan
