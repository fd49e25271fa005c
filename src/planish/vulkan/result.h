#pragma once

#include "planish/vulkan/functions.h"

namespace planish::vulkan {

/// The result as the Vulkan headers spell it, e.g. "VK_ERROR_DEVICE_LOST".
[[nodiscard]] const char* name_of(VkResult result);

/// Throws planish::Error when `result` is an error, with the call and the result spelled by name:
/// OutOfMemory, DeviceLost, or NoDevice for all else.
void check(VkResult result, const char* call);

}  // namespace planish::vulkan
