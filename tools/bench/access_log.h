#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "bench/options.h"
#include "planish/vulkan/backend/vulkan_machine.h"

namespace planish::bench {

/// What the lanes of a dispatch read and write of storage buffers.
struct AccessTotal {
  std::uint64_t read_bytes = 0, written_bytes = 0;
  /// Pieces of 32 bytes, at multiples of 32, that the accesses of 32 neighbouring lanes touch:
  /// each access of each round of its loops by itself, without a cache.
  std::uint64_t transactions = 0;
  /// The most rounds of its loops in which a lane makes one of its accesses.
  std::uint64_t longest_walk = 0;

  AccessTotal& operator+=(const AccessTotal& other) {
    read_bytes += other.read_bytes;
    written_bytes += other.written_bytes;
    transactions += other.transactions;
    longest_walk = std::max(longest_walk, other.longest_walk);
    return *this;
  }
};

/// A device whose kernels, those that hardware gets, record every access.
class AccessLog {
 public:
  /// The device is there.
  explicit AccessLog(const Options& options);
  ~AccessLog();
  AccessLog(const AccessLog&) = delete;
  AccessLog& operator=(const AccessLog&) = delete;

  [[nodiscard]] vulkan::VulkanMachine& machine() { return *machine_; }

  void clear();
  /// Of each dispatch since DeviceTrace::begin(), one work group high. Throws std::runtime_error
  /// where the log was too short.
  [[nodiscard]] std::vector<AccessTotal> totals(std::size_t dispatch_count);

 private:
  void bind();

  std::unique_ptr<vulkan::VulkanMachine> machine_;
  vulkan::Buffer records_;
  VkDescriptorPool pool_ = VK_NULL_HANDLE;
};

}  // namespace planish::bench
