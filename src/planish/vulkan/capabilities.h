#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "planish/vulkan/functions.h"

namespace planish::vulkan {

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

  bool usable = false;
  std::string reason;  ///< why not, naming the limit and its value; empty if usable
};

/// Fills in Capabilities. Throws only where the device answers with an error.
[[nodiscard]] Capabilities query_capabilities(PFN_vkGetInstanceProcAddr get_proc,
                                              VkInstance instance, VkPhysicalDevice device);

}  // namespace planish::vulkan
