#pragma once

#include "planish/vulkan/commands.h"
#include "planish/vulkan/context.h"
#include "planish/vulkan/result.h"

namespace planish::testing {

/// A host's own command buffer: begun, recorded into by others, submitted, waited for.
class HostCommands {
 public:
  HostCommands(const vulkan::Context& context, VkQueue queue, std::uint32_t queue_family)
      : context_(context), queue_(queue) {
    const vulkan::DeviceFunctions& vk = context.vk();
    VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
    pool.queueFamilyIndex = queue_family;
    vulkan::check(vk.vkCreateCommandPool(context.device(), &pool, nullptr, &pool_),
                  "vkCreateCommandPool");
    VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
    allocate.commandPool = pool_;
    allocate.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
    allocate.commandBufferCount = 1;
    vulkan::check(vk.vkAllocateCommandBuffers(context.device(), &allocate, &commands_),
                  "vkAllocateCommandBuffers");
  }
  ~HostCommands() { context_.vk().vkDestroyCommandPool(context_.device(), pool_, nullptr); }
  HostCommands(const HostCommands&) = delete;
  HostCommands& operator=(const HostCommands&) = delete;

  [[nodiscard]] VkCommandBuffer commands() const { return commands_; }

  void begin() {
    const vulkan::DeviceFunctions& vk = context_.vk();
    vulkan::check(vk.vkResetCommandPool(context_.device(), pool_, 0), "vkResetCommandPool");
    VkCommandBufferBeginInfo info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    vulkan::check(vk.vkBeginCommandBuffer(commands_, &info), "vkBeginCommandBuffer");
  }

  void end_submit_wait() {
    const vulkan::DeviceFunctions& vk = context_.vk();
    vulkan::check(vk.vkEndCommandBuffer(commands_), "vkEndCommandBuffer");
    VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &commands_;
    vulkan::check(vk.vkQueueSubmit(queue_, 1, &submit, VK_NULL_HANDLE), "vkQueueSubmit");
    vulkan::check(vk.vkDeviceWaitIdle(context_.device()), "vkDeviceWaitIdle");
  }

 private:
  const vulkan::Context& context_;
  VkQueue queue_;
  VkCommandPool pool_ = VK_NULL_HANDLE;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
};

}  // namespace planish::testing
