#pragma once

#include <vulkan/vulkan_core.h>

#include <cstdint>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <utility>

namespace planish::testing {

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

}  // namespace planish::testing
