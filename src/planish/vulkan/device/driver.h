#pragma once

#include <vulkan/vulkan_core.h>

#include <cstdint>
#include <string>
#include <vector>

#include "planish/core/error.h"

namespace planish::vulkan {

// No Vulkan symbol is linked: every function is asked of the host's vkGetInstanceProcAddr. Whether
// there are prototypes is the host's to say (VK_NO_PROTOTYPES): one that includes this first and
// its own Vulkan header after it may call them.

#define PLANISH_VULKAN_INSTANCE_FUNCTIONS(X)  \
  X(vkDestroyInstance)                        \
  X(vkEnumeratePhysicalDevices)               \
  X(vkEnumerateDeviceExtensionProperties)     \
  X(vkGetPhysicalDeviceProperties2)           \
  X(vkGetPhysicalDeviceMemoryProperties)      \
  X(vkGetPhysicalDeviceQueueFamilyProperties) \
  X(vkCreateDevice)                           \
  X(vkGetDeviceProcAddr)

#define PLANISH_VULKAN_DEVICE_FUNCTIONS(X) \
  X(vkDestroyDevice)                       \
  X(vkGetDeviceQueue)                      \
  X(vkQueueSubmit)                         \
  X(vkDeviceWaitIdle)                      \
  X(vkCreateFence)                         \
  X(vkDestroyFence)                        \
  X(vkResetFences)                         \
  X(vkWaitForFences)                       \
  X(vkCreateCommandPool)                   \
  X(vkDestroyCommandPool)                  \
  X(vkResetCommandPool)                    \
  X(vkAllocateCommandBuffers)              \
  X(vkBeginCommandBuffer)                  \
  X(vkEndCommandBuffer)                    \
  X(vkAllocateMemory)                      \
  X(vkFreeMemory)                          \
  X(vkMapMemory)                           \
  X(vkFlushMappedMemoryRanges)             \
  X(vkInvalidateMappedMemoryRanges)        \
  X(vkCreateBuffer)                        \
  X(vkDestroyBuffer)                       \
  X(vkCreateBufferView)                    \
  X(vkDestroyBufferView)                   \
  X(vkGetBufferMemoryRequirements)         \
  X(vkBindBufferMemory)                    \
  X(vkCreateShaderModule)                  \
  X(vkDestroyShaderModule)                 \
  X(vkCreateDescriptorSetLayout)           \
  X(vkDestroyDescriptorSetLayout)          \
  X(vkCreatePipelineLayout)                \
  X(vkDestroyPipelineLayout)               \
  X(vkCreateComputePipelines)              \
  X(vkDestroyPipeline)                     \
  X(vkCreateDescriptorPool)                \
  X(vkDestroyDescriptorPool)               \
  X(vkAllocateDescriptorSets)              \
  X(vkUpdateDescriptorSets)                \
  X(vkCmdBindPipeline)                     \
  X(vkCmdBindDescriptorSets)               \
  X(vkCmdPushConstants)                    \
  X(vkCmdDispatch)                         \
  X(vkCmdDispatchIndirect)                 \
  X(vkCmdWriteTimestamp)                   \
  X(vkCmdPipelineBarrier)                  \
  X(vkCmdCopyBuffer)                       \
  X(vkCmdFillBuffer)

#define PLANISH_VULKAN_MEMBER(name) PFN_##name name = nullptr;

/// Functions of one instance.
struct InstanceFunctions {
  PLANISH_VULKAN_INSTANCE_FUNCTIONS(PLANISH_VULKAN_MEMBER)

  /// Throws Error{NoDevice} naming a function that is missing.
  static InstanceFunctions load(PFN_vkGetInstanceProcAddr get, VkInstance instance);
};

/// Functions of one device.
struct DeviceFunctions {
  PLANISH_VULKAN_DEVICE_FUNCTIONS(PLANISH_VULKAN_MEMBER)

  /// Throws Error{NoDevice} naming a function that is missing.
  static DeviceFunctions load(PFN_vkGetDeviceProcAddr get, VkDevice device);
};

#undef PLANISH_VULKAN_MEMBER

/// Whether an instance may be made with the extension.
[[nodiscard]] bool has_instance_extension(PFN_vkGetInstanceProcAddr get, const char* name);

/// A handle as a number: handles are pointers or integers, by platform.
template <class Handle>
[[nodiscard]] std::uint64_t handle_number(Handle handle) {
  return (std::uint64_t)handle;
}

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

inline constexpr const char* kSmallerMesh = "use --device cpu or a smaller mesh";
inline constexpr const char* kFewerInstances = "use a smaller mesh or fewer instances";

/// Bytes that one binding may span, and the name of the device's limit that says so.
struct BindingLimit {
  std::uint64_t bytes = 0;
  const char* name = "maxStorageBufferRange";

  [[nodiscard]] bool allows(std::uint64_t wanted) const { return wanted <= bytes; }
  /// Throws Error{OutOfMemory} where it does not, with what takes so many bytes, limit and remedy.
  void require(std::uint64_t wanted, const std::string& what,
               const std::string& remedy = kSmallerMesh) const;
};

/// Something that planish does without, but would use.
struct OptionalFeature {
  std::string name;
  bool available = false;
  std::string use;  ///< what it is good for, as a sentence's end
};

/// What a physical device offers, and whether that is enough. Asked before a device is created.
struct Capabilities {
  std::string name;
  std::string kind;    ///< "gpu", or "software" for a device that runs on the CPU
  std::string uuid;    ///< 32 hexadecimal digits in groups of 8-4-4-4-12
  std::string driver;  ///< name and version
  std::uint32_t api_version = 0;
  VkPhysicalDeviceType type = VK_PHYSICAL_DEVICE_TYPE_OTHER;

  std::uint64_t max_storage_range = 0;    ///< maxStorageBufferRange, bytes
  std::uint64_t max_allocation = 0;       ///< maxMemoryAllocationSize, bytes
  std::uint64_t largest_device_heap = 0;  ///< bytes
  std::uint64_t max_texel_elements = 0;   ///< maxTexelBufferElements
  std::uint32_t max_group_count = 0;      ///< maxComputeWorkGroupCount[0]
  std::uint32_t max_storage_buffers = 0;  ///< maxPerStageDescriptorStorageBuffers
  std::uint64_t non_coherent_atom = 1;    ///< nonCoherentAtomSize, bytes
  VkPhysicalDeviceMemoryProperties memory{};
  std::uint32_t compute_family = 0;  ///< a family with compute, without graphics if there is one

  std::uint32_t timestamp_bits = 0;  ///< of that family; 0: it has no timestamps
  std::uint32_t subgroup_size = 0;   ///< for information: no kernel uses subgroup operations

  /// Device extensions that a host must enable on this device: VK_KHR_portability_subset where the
  /// device has it, that is, where it is a layer over another API.
  std::vector<std::string> required_extensions;
  bool portability_subset = false;
  std::vector<OptionalFeature> optional_features;

  bool usable = false;
  std::string reason;  ///< why not, naming the limit and its value; empty if usable
};

/// Fills in Capabilities, before a VkDevice exists. The instance is of Vulkan 1.1 at least. Throws
/// only where the device answers with an error.
[[nodiscard]] Capabilities query_capabilities(PFN_vkGetInstanceProcAddr get_proc,
                                              VkInstance instance, VkPhysicalDevice device);

}  // namespace planish::vulkan
