#include "planish/vulkan/device/fenced_commands.h"

#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/device/result.h"

namespace planish::vulkan {

FencedCommands::FencedCommands(Context& context, std::uint32_t queue_family) : context_(context) {
  const DeviceFunctions& vk = context.vk();
  VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  pool.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT;
  pool.queueFamilyIndex = queue_family;
  check(vk.vkCreateCommandPool(context.device(), &pool, context.callbacks(), &pool_),
        "vkCreateCommandPool");
  VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  allocate.commandPool = pool_;
  allocate.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  allocate.commandBufferCount = 1;
  VkResult result = vk.vkAllocateCommandBuffers(context.device(), &allocate, &commands_);
  VkFenceCreateInfo fence{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
  if (result == VK_SUCCESS)
    result = vk.vkCreateFence(context.device(), &fence, context.callbacks(), &fence_);
  if (result != VK_SUCCESS) vk.vkDestroyCommandPool(context.device(), pool_, context.callbacks());
  check(result, "vkCreateFence");
}

FencedCommands::~FencedCommands() {
  const DeviceFunctions& vk = context_.vk();
  vk.vkDestroyFence(context_.device(), fence_, context_.callbacks());
  vk.vkDestroyCommandPool(context_.device(), pool_, context_.callbacks());
}

void FencedCommands::submit(VkQueue queue, const std::function<void(VkCommandBuffer)>& record) {
  const DeviceFunctions& vk = context_.vk();
  check(vk.vkResetCommandPool(context_.device(), pool_, 0), "vkResetCommandPool");
  VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  check(vk.vkBeginCommandBuffer(commands_, &begin), "vkBeginCommandBuffer");
  record(commands_);
  record_barrier(context_, commands_, kExitScope, kHostReadScope);
  check(vk.vkEndCommandBuffer(commands_), "vkEndCommandBuffer");
  VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
  submit.commandBufferCount = 1;
  submit.pCommandBuffers = &commands_;
  check(vk.vkResetFences(context_.device(), 1, &fence_), "vkResetFences");
  check(vk.vkQueueSubmit(queue, 1, &submit, fence_), "vkQueueSubmit");
}

VkResult FencedCommands::wait(std::uint64_t nanoseconds) const {
  return context_.vk().vkWaitForFences(context_.device(), 1, &fence_, VK_TRUE, nanoseconds);
}

}  // namespace planish::vulkan
