#pragma once

#include <cstdint>

#include "planish/vulkan/backend/vulkan_machine.h"

namespace planish::bench {

/// Two buffers on a device, and the two ways to copy one to the other: what the kernels' speeds are
/// measured against. The machine outlives it.
class DeviceCopy {
 public:
  /// Buffers of `bytes`, or of what a binding and an eighth of the device's memory hold.
  DeviceCopy(vulkan::VulkanMachine& machine, std::uint64_t bytes);
  ~DeviceCopy();
  DeviceCopy(const DeviceCopy&) = delete;
  DeviceCopy& operator=(const DeviceCopy&) = delete;

  /// Bytes of each buffer; a copy reads as many and writes as many.
  [[nodiscard]] std::uint64_t bytes() const { return source_.size(); }
  void record_kernel(VkCommandBuffer commands) const;
  void record_command(VkCommandBuffer commands) const;
  /// Whether the target holds what the source does; fills the target with something else.
  [[nodiscard]] bool has_copied();

 private:
  void make_pipeline();
  void make_set();
  void destroy() noexcept;

  vulkan::VulkanMachine& machine_;
  vulkan::Buffer source_, target_;
  VkDescriptorSetLayout set_layout_ = VK_NULL_HANDLE;
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
  VkPipeline pipeline_ = VK_NULL_HANDLE;
  VkDescriptorPool pool_ = VK_NULL_HANDLE;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
};

}  // namespace planish::bench
