#pragma once

#include "planish/vulkan/embed.h"

namespace planish::vulkan {

/// The first of a call's two timestamps; nothing where the host wants none. At the compute stage,
/// where the kernels wait, too: nothing holds back a timestamp at the top of the pipe, which would
/// count the end of the work before.
inline void write_first(const Context& context, VkCommandBuffer commands,
                        const Timestamps& timestamps) noexcept {
  if (timestamps.pool)
    context.vk().vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                                     timestamps.pool, timestamps.first);
}

/// The second one, after all that the call recorded.
inline void write_second(const Context& context, VkCommandBuffer commands,
                         const Timestamps& timestamps) noexcept {
  if (timestamps.pool)
    context.vk().vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT,
                                     timestamps.pool, timestamps.first + 1);
}

}  // namespace planish::vulkan
