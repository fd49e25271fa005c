#include "planish/osd/submission.h"

#include <utility>

#include "planish/vulkan/commands.h"
#include "planish/vulkan/result.h"

namespace planish::osd {

using vulkan::check;

Submission::Submission(vulkan::Context& context, std::uint32_t queueFamily) : _context(context) {
  vulkan::DeviceFunctions const& vk = context.vk();
  VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  pool.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT;
  pool.queueFamilyIndex = queueFamily;
  check(vk.vkCreateCommandPool(context.device(), &pool, context.callbacks(), &_pool),
        "vkCreateCommandPool");
  VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  allocate.commandPool = _pool;
  allocate.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  allocate.commandBufferCount = 1;
  VkResult result = vk.vkAllocateCommandBuffers(context.device(), &allocate, &_commands);
  VkFenceCreateInfo fence{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
  if (result == VK_SUCCESS)
    result = vk.vkCreateFence(context.device(), &fence, context.callbacks(), &_fence);
  if (result != VK_SUCCESS) vk.vkDestroyCommandPool(context.device(), _pool, context.callbacks());
  check(result, "vkCreateFence");
}

Submission::~Submission() {
  vulkan::DeviceFunctions const& vk = _context.vk();
  if (_pending) vk.vkWaitForFences(_context.device(), 1, &_fence, VK_TRUE, UINT64_MAX);
  vk.vkDestroyFence(_context.device(), _fence, _context.callbacks());
  vk.vkDestroyCommandPool(_context.device(), _pool, _context.callbacks());
}

bool Submission::IsDone(std::uint64_t nanoseconds) {
  if (!_pending) return true;
  vulkan::DeviceFunctions const& vk = _context.vk();
  VkResult const result = vk.vkWaitForFences(_context.device(), 1, &_fence, VK_TRUE, nanoseconds);
  if (result == VK_TIMEOUT) return false;
  check(result, "vkWaitForFences");
  check(vk.vkResetFences(_context.device(), 1, &_fence), "vkResetFences");
  _pending = false;
  _resources.clear();
  return true;
}

void Submission::Submit(VkQueue queue, std::function<void(VkCommandBuffer)> const& record,
                        std::shared_ptr<void> resources) {
  vulkan::DeviceFunctions const& vk = _context.vk();
  check(vk.vkResetCommandPool(_context.device(), _pool, 0), "vkResetCommandPool");
  VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  check(vk.vkBeginCommandBuffer(_commands, &begin), "vkBeginCommandBuffer");
  record(_commands);
  vulkan::record_barrier(_context, _commands, vulkan::kExitScope, vulkan::kHostReadScope);
  check(vk.vkEndCommandBuffer(_commands), "vkEndCommandBuffer");
  VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
  submit.commandBufferCount = 1;
  submit.pCommandBuffers = &_commands;
  check(vk.vkQueueSubmit(queue, 1, &submit, _fence), "vkQueueSubmit");
  _pending = true;
  _resources.push_back(std::move(resources));
}

}  // namespace planish::osd
