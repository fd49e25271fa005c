#pragma once

// No Vulkan symbol is linked: every function is asked of the host's vkGetInstanceProcAddr. Whether
// there are prototypes is the host's to say (VK_NO_PROTOTYPES): one that includes this first and
// its own Vulkan header after it may call them.
#include <vulkan/vulkan_core.h>

#include <cstdint>

namespace planish::vulkan {

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

}  // namespace planish::vulkan
