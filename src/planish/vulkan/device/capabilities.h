#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "planish/vulkan/device/functions.h"

namespace planish::vulkan {

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
