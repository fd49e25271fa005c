#pragma once

#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/device/context.h"
#include "planish/vulkan/device/driver.h"

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

/// A buffer that a host made for itself, with memory of its own.
class HostBuffer {
 public:
  HostBuffer(vulkan::Context& context, VkDeviceSize size, VkBufferUsageFlags usage)
      : context_(context) {
    const vulkan::DeviceFunctions& vk = context.vk();
    VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    info.size = size;
    info.usage = usage;
    vulkan::check(vk.vkCreateBuffer(context.device(), &info, nullptr, &buffer_), "vkCreateBuffer");
    vulkan::MemoryRequest request{{}, vulkan::MemoryUse::Device};
    vk.vkGetBufferMemoryRequirements(context.device(), buffer_, &request.requirements);
    size_ = request.requirements.size;
    block_ = context.memory().allocate(request);
    vulkan::check(vk.vkBindBufferMemory(context.device(), buffer_, block_.memory, block_.offset),
                  "vkBindBufferMemory");
  }
  ~HostBuffer() {
    context_.vk().vkDestroyBuffer(context_.device(), buffer_, nullptr);
    context_.memory().free(block_, size_);
  }
  HostBuffer(const HostBuffer&) = delete;
  HostBuffer& operator=(const HostBuffer&) = delete;

  [[nodiscard]] VkBuffer handle() const { return buffer_; }

 private:
  vulkan::Context& context_;
  VkBuffer buffer_ = VK_NULL_HANDLE;
  vulkan::MemoryBlock block_;
  VkDeviceSize size_ = 0;
};

}  // namespace planish::testing
