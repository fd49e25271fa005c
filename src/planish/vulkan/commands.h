#pragma once

#include "planish/vulkan/context.h"

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
/// Everything that a record_ function does; what a host's own barriers pair with.
inline constexpr Scope kEntryScope{kKernelScope.stages | kCopyScope.stages,
                                   kKernelScope.accesses | kCopyScope.accesses};
inline constexpr Scope kExitScope = kEntryScope;
inline constexpr Scope kHostReadScope{VK_PIPELINE_STAGE_HOST_BIT, VK_ACCESS_HOST_READ_BIT};

void record_barrier(const Context& context, VkCommandBuffer commands, const Scope& from,
                    const Scope& to) noexcept;

/// `parameters` points to the kernel's own push constants.
void record_dispatch(const Context& context, VkCommandBuffer commands, Kernel kernel,
                     VkDescriptorSet set, const void* parameters, std::uint32_t groups) noexcept;

}  // namespace planish::vulkan
