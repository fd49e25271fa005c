#pragma once

#include <cstdint>

#include "planish/vulkan/device/functions.h"

namespace planish::vulkan {

/// Names of objects and labels of recorded work for debuggers. Does nothing where the host did not
/// enable VK_EXT_debug_utils.
class DebugLabels {
 public:
  DebugLabels() = default;
  /// Throws Error{InvalidArgument} where the extension's functions cannot be had.
  DebugLabels(PFN_vkGetInstanceProcAddr get, VkInstance instance, VkDevice device);

  void name(VkObjectType type, std::uint64_t handle, const char* name) const noexcept;
  void begin(VkCommandBuffer commands, const char* label) const noexcept;
  void end(VkCommandBuffer commands) const noexcept;

 private:
  VkDevice device_ = VK_NULL_HANDLE;
  PFN_vkSetDebugUtilsObjectNameEXT set_name_ = nullptr;
  PFN_vkCmdBeginDebugUtilsLabelEXT begin_ = nullptr;
  PFN_vkCmdEndDebugUtilsLabelEXT end_ = nullptr;
};

}  // namespace planish::vulkan
