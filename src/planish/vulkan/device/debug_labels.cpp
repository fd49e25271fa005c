#include "planish/vulkan/device/debug_labels.h"

#include <string>

#include "planish/core/error.h"

namespace planish::vulkan {

DebugLabels::DebugLabels(PFN_vkGetInstanceProcAddr get, VkInstance instance, VkDevice device)
    : device_(device) {
  const auto load = [&](auto& function, const char* name) {
    function = reinterpret_cast<std::decay_t<decltype(function)>>(get(instance, name));
    if (!function)
      throw Error(
          ErrorCode::InvalidArgument,
          std::string("the host says that it enabled VK_EXT_debug_utils, but there is no ") + name);
  };
  load(set_name_, "vkSetDebugUtilsObjectNameEXT");
  load(begin_, "vkCmdBeginDebugUtilsLabelEXT");
  load(end_, "vkCmdEndDebugUtilsLabelEXT");
}

void DebugLabels::name(VkObjectType type, std::uint64_t handle, const char* name) const noexcept {
  if (!set_name_ || !name) return;
  VkDebugUtilsObjectNameInfoEXT info{VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT};
  info.objectType = type;
  info.objectHandle = handle;
  info.pObjectName = name;
  // A name that cannot be set is no reason to fail.
  static_cast<void>(set_name_(device_, &info));
}

void DebugLabels::begin(VkCommandBuffer commands, const char* label) const noexcept {
  if (!begin_) return;
  VkDebugUtilsLabelEXT info{VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT};
  info.pLabelName = label;
  begin_(commands, &info);
}

void DebugLabels::end(VkCommandBuffer commands) const noexcept {
  if (end_) end_(commands);
}

}  // namespace planish::vulkan
