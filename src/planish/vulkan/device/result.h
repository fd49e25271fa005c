#pragma once

#include <string>

#include "planish/core/error.h"
#include "planish/vulkan/device/functions.h"

namespace planish::vulkan {

/// A Vulkan call failed. The message names call and result: `vkAllocateMemory:
/// VK_ERROR_OUT_OF_DEVICE_MEMORY`.
class VulkanError : public Error {
 public:
  VulkanError(ErrorCode code, const std::string& message, VkResult result)
      : Error(code, message), result_(result) {}
  [[nodiscard]] VkResult result() const noexcept { return result_; }

 private:
  VkResult result_;
};

/// The result as the Vulkan headers spell it, e.g. "VK_ERROR_DEVICE_LOST".
[[nodiscard]] const char* name_of(VkResult result);

/// Throws VulkanError when `result` is an error: OutOfMemory, DeviceLost, or NoDevice for all else.
void check(VkResult result, const char* call);

}  // namespace planish::vulkan
