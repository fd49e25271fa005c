#include "planish/vulkan/device/result.h"

#include <string>

namespace planish::vulkan {

const char* name_of(VkResult result) {
#define PLANISH_VULKAN_CASE(name) \
  case name:                      \
    return #name;
  switch (result) {
    PLANISH_VULKAN_CASE(VK_SUCCESS)
    PLANISH_VULKAN_CASE(VK_NOT_READY)
    PLANISH_VULKAN_CASE(VK_TIMEOUT)
    PLANISH_VULKAN_CASE(VK_INCOMPLETE)
    PLANISH_VULKAN_CASE(VK_ERROR_OUT_OF_HOST_MEMORY)
    PLANISH_VULKAN_CASE(VK_ERROR_OUT_OF_DEVICE_MEMORY)
    PLANISH_VULKAN_CASE(VK_ERROR_INITIALIZATION_FAILED)
    PLANISH_VULKAN_CASE(VK_ERROR_DEVICE_LOST)
    PLANISH_VULKAN_CASE(VK_ERROR_MEMORY_MAP_FAILED)
    PLANISH_VULKAN_CASE(VK_ERROR_LAYER_NOT_PRESENT)
    PLANISH_VULKAN_CASE(VK_ERROR_EXTENSION_NOT_PRESENT)
    PLANISH_VULKAN_CASE(VK_ERROR_FEATURE_NOT_PRESENT)
    PLANISH_VULKAN_CASE(VK_ERROR_INCOMPATIBLE_DRIVER)
    PLANISH_VULKAN_CASE(VK_ERROR_TOO_MANY_OBJECTS)
    PLANISH_VULKAN_CASE(VK_ERROR_FRAGMENTED_POOL)
    PLANISH_VULKAN_CASE(VK_ERROR_UNKNOWN)
    PLANISH_VULKAN_CASE(VK_ERROR_OUT_OF_POOL_MEMORY)
    PLANISH_VULKAN_CASE(VK_ERROR_FRAGMENTATION)
    default:
      return "unknown VkResult";
  }
#undef PLANISH_VULKAN_CASE
}

void check(VkResult result, const char* call) {
  if (result >= 0) return;
  const std::string message = std::string(call) + ": " + name_of(result);
  switch (result) {
    case VK_ERROR_OUT_OF_HOST_MEMORY:
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
    case VK_ERROR_OUT_OF_POOL_MEMORY:
    case VK_ERROR_TOO_MANY_OBJECTS:
      throw VulkanError(ErrorCode::OutOfMemory, message, result);
    case VK_ERROR_DEVICE_LOST:
      throw VulkanError(ErrorCode::DeviceLost, message, result);
    default:
      throw VulkanError(ErrorCode::NoDevice, message, result);
  }
}

}  // namespace planish::vulkan
