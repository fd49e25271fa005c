#include "planish/vulkan/device/driver.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "planish/core/error.h"
#include "planish/vulkan/device/bindings.h"

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

void BindingLimit::require(std::uint64_t wanted, const std::string& what,
                           const std::string& remedy) const {
  if (allows(wanted)) return;
  throw Error(ErrorCode::OutOfMemory, formatted("{} take {} bytes of one binding, but {} is {}; {}",
                                                what, wanted, name, bytes, remedy));
}

namespace {

std::string version_text(std::uint32_t version) {
  return formatted("{}.{}.{}", VK_API_VERSION_MAJOR(version), VK_API_VERSION_MINOR(version),
                   VK_API_VERSION_PATCH(version));
}

std::string uuid_text(const std::uint8_t (&uuid)[VK_UUID_SIZE]) {
  std::string text;
  for (int i = 0; i < static_cast<int>(VK_UUID_SIZE); ++i) {
    if (i == 4 || i == 6 || i == 8 || i == 10) text += '-';
    char digits[3];
    std::snprintf(digits, sizeof digits, "%02x", uuid[i]);
    text += digits;
  }
  return text;
}

constexpr const char* kPortabilitySubset = "VK_KHR_portability_subset";

bool has_extension(const InstanceFunctions& vk, VkPhysicalDevice device, const char* name) {
  std::uint32_t count = 0;
  check(vk.vkEnumerateDeviceExtensionProperties(device, nullptr, &count, nullptr),
        "vkEnumerateDeviceExtensionProperties");
  std::vector<VkExtensionProperties> extensions(count);
  check(vk.vkEnumerateDeviceExtensionProperties(device, nullptr, &count, extensions.data()),
        "vkEnumerateDeviceExtensionProperties");
  return std::any_of(extensions.begin(), extensions.end(), [&](const auto& extension) {
    return std::strcmp(extension.extensionName, name) == 0;
  });
}

void query_properties(const InstanceFunctions& vk, VkPhysicalDevice device, Capabilities& result) {
  VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2};
  vk.vkGetPhysicalDeviceProperties2(device, &properties);
  const VkPhysicalDeviceProperties& core = properties.properties;
  result.name = core.deviceName;
  result.api_version = core.apiVersion;
  result.type = core.deviceType;
  result.kind = result.type == VK_PHYSICAL_DEVICE_TYPE_CPU ? "software" : "gpu";
  result.driver = version_text(core.driverVersion);
  result.max_storage_range = core.limits.maxStorageBufferRange;
  result.max_texel_elements = core.limits.maxTexelBufferElements;
  result.max_group_count = core.limits.maxComputeWorkGroupCount[0];
  result.max_storage_buffers = core.limits.maxPerStageDescriptorStorageBuffers;
  result.non_coherent_atom = core.limits.nonCoherentAtomSize;
  if (core.apiVersion < VK_API_VERSION_1_1) return;

  VkPhysicalDeviceDriverProperties driver{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
  VkPhysicalDeviceIDProperties id{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ID_PROPERTIES};
  VkPhysicalDeviceSubgroupProperties subgroup{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES,
                                              &id};
  VkPhysicalDeviceMaintenance3Properties maintenance{
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES, &subgroup};
  const bool has_driver = has_extension(vk, device, VK_KHR_DRIVER_PROPERTIES_EXTENSION_NAME);
  if (has_driver) id.pNext = &driver;
  properties.pNext = &maintenance;
  vk.vkGetPhysicalDeviceProperties2(device, &properties);
  result.uuid = uuid_text(id.deviceUUID);
  result.subgroup_size = subgroup.subgroupSize;
  result.max_allocation = maintenance.maxMemoryAllocationSize;
  if (has_driver) result.driver = std::string(driver.driverName) + " " + driver.driverInfo;
  result.portability_subset = has_extension(vk, device, kPortabilitySubset);
  if (result.portability_subset) result.required_extensions.push_back(kPortabilitySubset);
}

// Returns whether there is a queue family with compute.
bool find_compute_family(const InstanceFunctions& vk, VkPhysicalDevice device,
                         Capabilities& result) {
  std::uint32_t count = 0;
  vk.vkGetPhysicalDeviceQueueFamilyProperties(device, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vk.vkGetPhysicalDeviceQueueFamilyProperties(device, &count, families.data());
  bool found = false;
  for (std::uint32_t i = 0; i < count; ++i) {
    const VkQueueFlags flags = families[i].queueFlags;
    if (!(flags & VK_QUEUE_COMPUTE_BIT)) continue;
    if (found && (flags & VK_QUEUE_GRAPHICS_BIT)) continue;
    result.compute_family = i;
    result.timestamp_bits = families[i].timestampValidBits;
    found = true;
  }
  return found;
}

std::vector<OptionalFeature> optional_features(const Capabilities& device, bool debug_utils) {
  return {{"timestamps", device.timestamp_bits > 0, "recorded work can be timed on the device"},
          {VK_EXT_DEBUG_UTILS_EXTENSION_NAME, debug_utils,
           "objects and recorded work have names in debuggers"}};
}

std::string why_not_usable(const Capabilities& device, bool has_compute) {
  if (device.api_version < VK_API_VERSION_1_1)
    return "offers Vulkan " + version_text(device.api_version) + ", 1.1 is needed";
  if (!has_compute) return "has no queue family with compute";
  if (device.max_storage_buffers < kMaxBindings)
    return formatted("maxPerStageDescriptorStorageBuffers is {}, {} are needed",
                     device.max_storage_buffers, kMaxBindings);
  return {};
}

}  // namespace

Capabilities query_capabilities(PFN_vkGetInstanceProcAddr get_proc, VkInstance instance,
                                VkPhysicalDevice device) {
  const InstanceFunctions vk = InstanceFunctions::load(get_proc, instance);
  Capabilities result;
  query_properties(vk, device, result);
  vk.vkGetPhysicalDeviceMemoryProperties(device, &result.memory);
  for (std::uint32_t i = 0; i < result.memory.memoryHeapCount; ++i) {
    const VkMemoryHeap& heap = result.memory.memoryHeaps[i];
    if (heap.flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT)
      result.largest_device_heap = std::max<std::uint64_t>(result.largest_device_heap, heap.size);
  }
  const bool has_compute = find_compute_family(vk, device, result);
  result.optional_features = optional_features(
      result, has_instance_extension(get_proc, VK_EXT_DEBUG_UTILS_EXTENSION_NAME));
  result.reason = why_not_usable(result, has_compute);
  result.usable = result.reason.empty();
  return result;
}

}  // namespace planish::vulkan
