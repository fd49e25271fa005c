#pragma once

#include <vulkan/vulkan_core.h>

#include <algorithm>
#include <cstdint>
#include <mutex>
#include <set>
#include <utility>
#include <vector>

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

}  // namespace planish::testing
