#include "vulkan/host_commands.h"

#include "planish/vulkan/device/commands.h"

namespace planish::testing {

using namespace vulkan;

HostCommands::HostCommands(const OwnDevice& device, VkCommandBufferLevel level)
    : host_(device.host_device()),
      vk_(DeviceFunctions::load(
          InstanceFunctions::load(host_.get_instance_proc, host_.instance).vkGetDeviceProcAddr,
          host_.device)),
      queue_(device.queue()),
      level_(level) {
  VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  pool.queueFamilyIndex = device.capabilities().compute_family;
  check(vk_.vkCreateCommandPool(host_.device, &pool, nullptr, &pool_), "vkCreateCommandPool");
  VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  allocate.commandPool = pool_;
  allocate.level = level;
  allocate.commandBufferCount = 1;
  check(vk_.vkAllocateCommandBuffers(host_.device, &allocate, &commands_),
        "vkAllocateCommandBuffers");
  const VkFenceCreateInfo fence{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
  check(vk_.vkCreateFence(host_.device, &fence, nullptr, &fence_), "vkCreateFence");
}

HostCommands::~HostCommands() {
  vk_.vkDestroyFence(host_.device, fence_, nullptr);
  vk_.vkDestroyCommandPool(host_.device, pool_, nullptr);
}

void HostCommands::record(const std::function<void(VkCommandBuffer)>& work) {
  check(vk_.vkResetCommandPool(host_.device, pool_, 0), "vkResetCommandPool");
  const VkCommandBufferInheritanceInfo inheritance{
      VK_STRUCTURE_TYPE_COMMAND_BUFFER_INHERITANCE_INFO};
  VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  if (level_ == VK_COMMAND_BUFFER_LEVEL_SECONDARY) begin.pInheritanceInfo = &inheritance;
  check(vk_.vkBeginCommandBuffer(commands_, &begin), "vkBeginCommandBuffer");
  work(commands_);
  // The host reads what planish wrote.
  VkMemoryBarrier barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER};
  barrier.srcAccessMask = kExitScope.accesses;
  barrier.dstAccessMask = kHostReadScope.accesses;
  vk_.vkCmdPipelineBarrier(commands_, kExitScope.stages, kHostReadScope.stages, 0, 1, &barrier, 0,
                           nullptr, 0, nullptr);
  check(vk_.vkEndCommandBuffer(commands_), "vkEndCommandBuffer");
}

void HostCommands::submit() {
  check(vk_.vkResetFences(host_.device, 1, &fence_), "vkResetFences");
  VkSubmitInfo info{VK_STRUCTURE_TYPE_SUBMIT_INFO};
  info.commandBufferCount = 1;
  info.pCommandBuffers = &commands_;
  check(vk_.vkQueueSubmit(queue_, 1, &info, fence_), "vkQueueSubmit");
}

void HostCommands::wait() {
  check(vk_.vkWaitForFences(host_.device, 1, &fence_, VK_TRUE, UINT64_MAX), "vkWaitForFences");
}

}  // namespace planish::testing
