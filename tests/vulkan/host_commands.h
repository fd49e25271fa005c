#pragma once

#include <functional>

#include "planish/vulkan/device/driver.h"
#include "planish/vulkan/device/own_device.h"

namespace planish::testing {

/// A command buffer that a host records once and submits as often as it likes, with a fence. Made
/// of functions that the host loads for itself.
class HostCommands {
 public:
  HostCommands(const vulkan::OwnDevice& device,
               VkCommandBufferLevel level = VK_COMMAND_BUFFER_LEVEL_PRIMARY);
  ~HostCommands();
  HostCommands(const HostCommands&) = delete;
  HostCommands& operator=(const HostCommands&) = delete;

  void record(const std::function<void(VkCommandBuffer)>& work);
  void submit();
  void wait();
  [[nodiscard]] VkCommandBuffer handle() const { return commands_; }
  [[nodiscard]] const vulkan::DeviceFunctions& vk() const { return vk_; }

 private:
  vulkan::HostDevice host_;
  vulkan::DeviceFunctions vk_;
  VkQueue queue_;
  VkCommandBufferLevel level_;
  VkCommandPool pool_ = VK_NULL_HANDLE;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
  VkFence fence_ = VK_NULL_HANDLE;
};

}  // namespace planish::testing
