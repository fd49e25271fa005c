#pragma once

#include <cstdint>
#include <functional>

#include "planish/vulkan/device/context.h"

namespace planish::vulkan {

/// A command buffer with a pool of its own and the fence of its submission. Externally
/// synchronised.
class FencedCommands {
 public:
  FencedCommands(Context& context, std::uint32_t queue_family);
  /// They must not be under way.
  ~FencedCommands();
  FencedCommands(const FencedCommands&) = delete;
  FencedCommands& operator=(const FencedCommands&) = delete;

  /// Records anew by `record`, makes what is written visible to the host, and submits. They must
  /// not be under way, and are not if this throws. Throws Error{DeviceLost}, Error{OutOfMemory}.
  void submit(VkQueue queue, const std::function<void(VkCommandBuffer)>& record);

  /// Waits up to `nanoseconds` for the last submission: VK_SUCCESS, VK_TIMEOUT or an error.
  [[nodiscard]] VkResult wait(std::uint64_t nanoseconds) const;

 private:
  Context& context_;
  VkCommandPool pool_ = VK_NULL_HANDLE;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
  VkFence fence_ = VK_NULL_HANDLE;
};

}  // namespace planish::vulkan
