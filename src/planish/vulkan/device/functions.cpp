#include "planish/vulkan/device/functions.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include "planish/core/error.h"

namespace planish::vulkan {

namespace {

template <class Function, class Get, class Handle>
void load_one(Function& function, Get get, Handle handle, const char* name) {
  function = reinterpret_cast<Function>(get(handle, name));
  if (!function)
    throw Error(ErrorCode::NoDevice,
                std::string("the Vulkan driver lacks ") + name + "; Vulkan 1.1 is needed");
}

}  // namespace

#define PLANISH_VULKAN_LOAD(name) load_one(functions.name, get, handle, #name);

InstanceFunctions InstanceFunctions::load(PFN_vkGetInstanceProcAddr get, VkInstance handle) {
  InstanceFunctions functions;
  PLANISH_VULKAN_INSTANCE_FUNCTIONS(PLANISH_VULKAN_LOAD)
  return functions;
}

DeviceFunctions DeviceFunctions::load(PFN_vkGetDeviceProcAddr get, VkDevice handle) {
  DeviceFunctions functions;
  PLANISH_VULKAN_DEVICE_FUNCTIONS(PLANISH_VULKAN_LOAD)
  return functions;
}

#undef PLANISH_VULKAN_LOAD

bool has_instance_extension(PFN_vkGetInstanceProcAddr get, const char* name) {
  const auto enumerate = reinterpret_cast<PFN_vkEnumerateInstanceExtensionProperties>(
      get(nullptr, "vkEnumerateInstanceExtensionProperties"));
  std::uint32_t count = 0;
  if (!enumerate || enumerate(nullptr, &count, nullptr) != VK_SUCCESS) return false;
  std::vector<VkExtensionProperties> extensions(count);
  if (enumerate(nullptr, &count, extensions.data()) != VK_SUCCESS) return false;
  return std::any_of(extensions.begin(), extensions.end(), [&](const auto& extension) {
    return std::strcmp(extension.extensionName, name) == 0;
  });
}

}  // namespace planish::vulkan
