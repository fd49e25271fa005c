#pragma once

#include <vulkan/vulkan_core.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "planish/vulkan/device/driver.h"

namespace planish::testing {

/// What calls were given, where it may break a rule that no driver of tests checks.
struct PretendedNotes {
  std::uint32_t largest_dispatch = 0;  ///< work groups in x of the largest vkCmdDispatch
  /// Buffers and offsets that vkCmdDispatchIndirect reads.
  std::vector<std::pair<VkBuffer, VkDeviceSize>> indirect_dispatches;
  std::set<VkPipelineStageFlags> timestamp_stages;
  std::set<VkBufferUsageFlags> buffer_usages;  ///< of all buffers made
};

/// Takes them from any thread: by its arguments' types a call is known.
class NoteTaker {
 public:
  template <class... A>
  void take(A...) {}
  void take(VkCommandBuffer, std::uint32_t x, std::uint32_t, std::uint32_t) {
    const std::lock_guard lock(mutex_);
    notes_.largest_dispatch = std::max(notes_.largest_dispatch, x);
  }
  void take(VkCommandBuffer, VkBuffer buffer, VkDeviceSize offset) {
    const std::lock_guard lock(mutex_);
    notes_.indirect_dispatches.emplace_back(buffer, offset);
  }
  void take(VkCommandBuffer, VkPipelineStageFlagBits stage, VkQueryPool, std::uint32_t) {
    const std::lock_guard lock(mutex_);
    notes_.timestamp_stages.insert(stage);
  }
  void take(VkDevice, const VkBufferCreateInfo* info, const VkAllocationCallbacks*, VkBuffer*) {
    const std::lock_guard lock(mutex_);
    notes_.buffer_usages.insert(info->usage);
  }

  void reset() {
    const std::lock_guard lock(mutex_);
    notes_ = {};
  }
  [[nodiscard]] PretendedNotes notes() const {
    const std::lock_guard lock(mutex_);
    return notes_;
  }

 private:
  mutable std::mutex mutex_;
  PretendedNotes notes_;
};

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

/// Limits that a call may not pass: the pretended ones of the driver, of which a validation layer
/// knows nothing, and the widest alignments that Vulkan lets any device ask for.
struct PretendedLimits {
  std::uint32_t group_count = 65535;          ///< maxComputeWorkGroupCount, which all devices have
  std::uint64_t storage_range = 0xffffffff;   ///< maxStorageBufferRange
  std::uint64_t texel_elements = 0xffffffff;  ///< maxTexelBufferElements
  std::uint64_t alignment = 256;  ///< of storage and texel buffers in their buffer, at most
  std::uint32_t push_bytes = 128;
};

/// Which calls break a rule, in words. Calls are known by their arguments' types; threads may call.
class RuleBook {
 public:
  template <class... A>
  void look(A...) {}
  // vkCmdDispatch
  void look(VkCommandBuffer, std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    constexpr std::uint32_t kOfAllDevices = 65535;  // in y and z, of which none has fewer
    for (const auto& [groups, most] :
         {std::pair{x, limits_.group_count}, {y, kOfAllDevices}, {z, kOfAllDevices}})
      expect(groups <= most, "vkCmdDispatch of " + std::to_string(groups) + " work groups");
  }
  // vkCmdDispatchIndirect
  void look(VkCommandBuffer, VkBuffer buffer, VkDeviceSize offset) {
    expect(offset % 4 == 0 && fits(buffer, offset, sizeof(VkDispatchIndirectCommand)),
           "vkCmdDispatchIndirect reads from " + std::to_string(offset));
  }
  // vkCmdPushConstants
  void look(VkCommandBuffer, VkPipelineLayout, VkShaderStageFlags, std::uint32_t offset,
            std::uint32_t size, const void*) {
    expect(size > 0 && offset + size <= limits_.push_bytes && size % 4 == 0,
           "vkCmdPushConstants of " + std::to_string(size) + " bytes");
  }
  // vkCmdCopyBuffer
  void look(VkCommandBuffer, VkBuffer from, VkBuffer to, std::uint32_t count,
            const VkBufferCopy* regions) {
    expect(count > 0, "vkCmdCopyBuffer of no region");
    for (std::uint32_t i = 0; i < count; ++i) {
      const VkBufferCopy& region = regions[i];
      const bool overlaps = from == to && region.srcOffset < region.dstOffset + region.size &&
                            region.dstOffset < region.srcOffset + region.size;
      expect(region.size > 0 && !overlaps && fits(from, region.srcOffset, region.size) &&
                 fits(to, region.dstOffset, region.size),
             "vkCmdCopyBuffer of " + std::to_string(region.size) + " bytes from " +
                 std::to_string(region.srcOffset) + " to " + std::to_string(region.dstOffset));
    }
  }
  // vkCmdFillBuffer
  void look(VkCommandBuffer, VkBuffer buffer, VkDeviceSize offset, VkDeviceSize size,
            std::uint32_t) {
    const bool is_whole = size == VK_WHOLE_SIZE;
    expect(offset % 4 == 0 && fits(buffer, offset, is_whole ? 4 : size) &&
               (is_whole || (size > 0 && size % 4 == 0)),
           "vkCmdFillBuffer of " + std::to_string(size) + " bytes from " + std::to_string(offset));
  }
  // vkUpdateDescriptorSets
  void look(VkDevice, std::uint32_t count, const VkWriteDescriptorSet* writes, std::uint32_t,
            const VkCopyDescriptorSet*) {
    for (std::uint32_t i = 0; i < count; ++i) {
      if (writes[i].descriptorType != VK_DESCRIPTOR_TYPE_STORAGE_BUFFER) continue;
      const VkDescriptorBufferInfo& at = *writes[i].pBufferInfo;
      expect(at.range <= limits_.storage_range && at.offset % limits_.alignment == 0 &&
                 at.range > 0 && fits(at.buffer, at.offset, at.range),
             "a storage binding of " + std::to_string(at.range) + " bytes from " +
                 std::to_string(at.offset));
    }
  }
  // vkCreateBufferView
  void look(VkDevice, const VkBufferViewCreateInfo* info, const VkAllocationCallbacks*,
            VkBufferView*) {
    const std::uint64_t texel = texel_bytes(info->format);
    expect(texel > 0 && info->range % texel == 0 && info->range / texel <= limits_.texel_elements &&
               info->offset % limits_.alignment == 0 && info->range > 0 &&
               fits(info->buffer, info->offset, info->range),
           "a texel buffer of " + std::to_string(info->range) + " bytes from " +
               std::to_string(info->offset) + " in format " + std::to_string(info->format));
  }

  template <class... A>
  void made(A...) {}
  // vkCreateBuffer
  void made(VkDevice, const VkBufferCreateInfo* info, const VkAllocationCallbacks*,
            VkBuffer* buffer) {
    const std::lock_guard lock(mutex_);
    sizes_[*buffer] = info->size;
  }

  void set_limits(const PretendedLimits& limits) {
    const std::lock_guard lock(mutex_);
    limits_ = limits;
  }
  void reset() {
    const std::lock_guard lock(mutex_);
    limits_ = {};
    broken_.clear();
    sizes_.clear();
  }
  [[nodiscard]] std::set<std::string> broken() const {
    const std::lock_guard lock(mutex_);
    return broken_;
  }

 private:
  void expect(bool holds, const std::string& what) {
    if (holds) return;
    const std::lock_guard lock(mutex_);
    broken_.insert(what);
  }
  // A buffer that nobody here has seen made is taken to be large enough.
  [[nodiscard]] bool fits(VkBuffer buffer, VkDeviceSize offset, VkDeviceSize size) const {
    const std::lock_guard lock(mutex_);
    const auto found = sizes_.find(buffer);
    return found == sizes_.end() || (offset <= found->second && size <= found->second - offset);
  }
  static std::uint64_t texel_bytes(VkFormat format) {
    switch (format) {
      case VK_FORMAT_R32_UINT:
      case VK_FORMAT_R32_SFLOAT:
        return 4;
      case VK_FORMAT_R32G32_UINT:
      case VK_FORMAT_R32G32_SFLOAT:
        return 8;
      case VK_FORMAT_R32G32B32A32_UINT:
      case VK_FORMAT_R32G32B32A32_SFLOAT:
        return 16;
      default:
        return 0;
    }
  }

  mutable std::mutex mutex_;
  PretendedLimits limits_;
  std::map<VkBuffer, VkDeviceSize> sizes_;
  std::set<std::string> broken_;
};

/// A vkGetInstanceProcAddr between planish and the loader: it counts what planish calls and what it
/// leaves alive, and on demand pretends that calls fail, that limits are low and that memory is not
/// what it is. Vulkan hands no state to functions: there is one, for one device at a time.
class PretendedDriver {
 public:
  /// Forgets all counts and pretends nothing.
  static void reset();
  static PFN_vkGetInstanceProcAddr get_proc();

  struct Pretence {
    std::uint32_t storage_buffers = 0;  ///< maxPerStageDescriptorStorageBuffers; 0: the real one
    std::uint32_t storage_range = 0;    ///< maxStorageBufferRange, bytes; 0: the real one
    std::uint64_t allocation_size = 0;  ///< maxMemoryAllocationSize, bytes; 0: the real one
    std::uint32_t texel_elements = 0;   ///< maxTexelBufferElements; 0: the real one
    std::uint32_t group_count = 0;      ///< maxComputeWorkGroupCount in x; 0: the real one
    /// Memory that only the device sees, and two types that the host sees, of which none is
    /// coherent.
    bool split_memory = false;
    /// Bytes of a heap of device memory that the host sees too, named before the host's own heap;
    /// 0: the real heaps. Device and host have 64 MiB and `host_bytes` beside it.
    std::uint64_t bar_bytes = 0, host_bytes = 64u << 20;
    bool no_subgroup_operations = false;
    std::uint32_t subgroup_size = 0;  ///< that is told of; 0: the real one
    bool no_timestamps = false;
    bool portability_subset = false;
    /// Two queue families: 0 without compute, and 1 that only computes.
    bool separate_compute = false;
    bool graphics_compute = false;  ///< of separate families, the first computes, too
    std::uint32_t api_version = 0;  ///< 0: the real one
    /// Submissions until the device is lost for good; negative: it never is.
    int submissions_left = -1;
    /// Which of the calls that return a VkResult fails, counted from 1; 0: none.
    int failing_call = 0;
    VkResult failure = VK_ERROR_OUT_OF_DEVICE_MEMORY;
  };
  static Pretence& pretence();

  /// Calls since reset() by function, only of functions that planish asked for.
  static std::map<std::string, int> counts();
  static int count(const std::string& function);
  /// Calls that return a VkResult and whose failure matters.
  static int fallible_calls();
  /// What vkCreate and vkAllocateMemory made and nothing destroyed, by kind; pools count for what
  /// is allocated from them.
  static std::map<std::string, int> alive();
  /// Functions that planish asked for and that are not counted.
  static std::map<std::string, int> uncounted();
  /// Of the pretended families: those that devices, queues and pools were made for.
  static std::set<std::uint32_t> used_families();
  /// Barriers that hand a buffer from one family to another, by both.
  static std::map<std::pair<std::uint32_t, std::uint32_t>, int> transfers();
  /// What was asked to be made visible to the device and to the host.
  static std::vector<VkMappedMemoryRange> flushed();
  static std::vector<VkMappedMemoryRange> invalidated();
  /// Dispatches, copies, bindings and texel buffers beyond the pretended limits, their buffers or
  /// the widest alignments, in words.
  static std::set<std::string> broken_rules();
  /// What calls were given.
  static PretendedNotes notes();
  static void forget_notes();
  /// Memory of the pretended type 0, which only the device sees, that was mapped.
  static int illegal_maps();
};

}  // namespace planish::testing
