#pragma once

#include <vulkan/vulkan_core.h>

#include <cstdint>

namespace planish::testing {

inline constexpr VkMemoryPropertyFlags kMappedMemory =
    VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;

/// The first of some types of memory, a bit each, that the host sees; 32 where none is.
[[nodiscard]] inline std::uint32_t mapped_type(const VkPhysicalDeviceMemoryProperties& memory,
                                               std::uint32_t types) {
  for (std::uint32_t type = 0; type < memory.memoryTypeCount; ++type)
    if ((types >> type & 1u) != 0 &&
        (memory.memoryTypes[type].propertyFlags & kMappedMemory) == kMappedMemory)
      return type;
  return 32;
}

/// Of a heap: memory that only the device sees, and two types that the host sees, neither coherent.
inline void split_memory(std::uint32_t heap, VkPhysicalDeviceMemoryProperties& memory) {
  memory.memoryTypeCount = 3;
  memory.memoryTypes[0] = {VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, heap};
  memory.memoryTypes[1] = {VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT, heap};
  memory.memoryTypes[2] = {VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_CACHED_BIT,
                           heap};
}

/// A discrete GPU's: 64 MiB of its own, so many bytes that the host sees too, and the host's.
[[nodiscard]] inline VkPhysicalDeviceMemoryProperties discrete_memory(std::uint64_t bar_bytes,
                                                                      std::uint64_t host_bytes) {
  VkPhysicalDeviceMemoryProperties memory{};
  memory.memoryTypeCount = 4;
  memory.memoryTypes[0] = {VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, 0};
  memory.memoryTypes[1] = {VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT | kMappedMemory, 1};
  memory.memoryTypes[2] = {kMappedMemory, 2};
  memory.memoryTypes[3] = {kMappedMemory | VK_MEMORY_PROPERTY_HOST_CACHED_BIT, 2};
  memory.memoryHeapCount = 3;
  memory.memoryHeaps[0] = {64u << 20, VK_MEMORY_HEAP_DEVICE_LOCAL_BIT};
  memory.memoryHeaps[1] = {bar_bytes, VK_MEMORY_HEAP_DEVICE_LOCAL_BIT};
  memory.memoryHeaps[2] = {host_bytes, 0};
  return memory;
}

}  // namespace planish::testing
