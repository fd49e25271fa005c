#pragma once

#include <cstdint>
#include <vector>

#include "planish/vulkan/backend/vulkan_machine.h"

namespace planish::bench {

/// A query pool of timestamps on a machine's device, which outlives it.
class DeviceClock {
 public:
  DeviceClock(vulkan::VulkanMachine& machine, std::uint32_t query_count);
  ~DeviceClock();
  DeviceClock(const DeviceClock&) = delete;
  DeviceClock& operator=(const DeviceClock&) = delete;

  /// VK_NULL_HANDLE where the device's queue has no timestamps.
  [[nodiscard]] VkQueryPool pool() const { return pool_; }
  /// Before the first timestamp of a command buffer.
  void record_reset(VkCommandBuffer commands) const;
  /// After the work that `commands` holds so far.
  void record(VkCommandBuffer commands, std::uint32_t query) const;
  /// Milliseconds from the timestamp of query `first` + 2 i to the one after it, for i below
  /// `count`; the submission has ended. Empty without a pool.
  [[nodiscard]] std::vector<double> spans(std::uint32_t first, std::uint32_t count) const;

 private:
  vulkan::VulkanMachine& machine_;
  std::uint32_t query_count_;
  VkQueryPool pool_ = VK_NULL_HANDLE;
  double ms_per_tick_ = 0;
  std::uint64_t mask_ = 0;  // of the bits that count
  PFN_vkDestroyQueryPool destroy_ = nullptr;
  PFN_vkCmdResetQueryPool reset_ = nullptr;
  PFN_vkGetQueryPoolResults results_ = nullptr;
};

}  // namespace planish::bench
