#include "bench/device_copy.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <span>

#include "bench/copy_vectors.spv.h"
#include "planish/vulkan/device/result.h"

namespace planish::bench {

namespace {

constexpr std::uint32_t kCopyLanes = 64;
constexpr std::uint64_t kVectorBytes = 16;

std::uint64_t fitting_bytes(const vulkan::Context& context, std::uint64_t bytes) {
  const std::uint64_t heap = context.capabilities().largest_device_heap / 8;
  const std::uint64_t most = std::min({bytes, context.max_storage_range(), heap});
  return std::max(most / kVectorBytes, std::uint64_t(kCopyLanes)) * kVectorBytes;
}

}  // namespace

DeviceCopy::DeviceCopy(vulkan::VulkanMachine& machine, std::uint64_t bytes)
    : machine_(machine),
      source_(machine.context, fitting_bytes(machine.context, bytes), vulkan::MemoryUse::Device),
      target_(machine.context, source_.size(), vulkan::MemoryUse::Device) {
  try {
    make_pipeline();
    make_set();
  } catch (...) {
    destroy();
    throw;
  }
  machine.submitter.run([&](VkCommandBuffer commands) {
    const vulkan::DeviceFunctions& vk = machine_.context.vk();
    vk.vkCmdFillBuffer(commands, source_.handle(), 0, VK_WHOLE_SIZE, 0x3f800000);
    vk.vkCmdFillBuffer(commands, target_.handle(), 0, VK_WHOLE_SIZE, 0);
  });
}

void DeviceCopy::make_pipeline() {
  const vulkan::DeviceFunctions& vk = machine_.context.vk();
  const VkDevice device = machine_.context.device();
  std::array<VkDescriptorSetLayoutBinding, 2> bindings{};
  for (std::uint32_t i = 0; i < bindings.size(); ++i)
    bindings[i] = {i, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
  VkDescriptorSetLayoutCreateInfo set_info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
  set_info.bindingCount = static_cast<std::uint32_t>(bindings.size());
  set_info.pBindings = bindings.data();
  vulkan::check(vk.vkCreateDescriptorSetLayout(device, &set_info, nullptr, &set_layout_),
                "vkCreateDescriptorSetLayout");
  const VkPushConstantRange range{VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(std::uint32_t)};
  VkPipelineLayoutCreateInfo layout_info{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
  layout_info.setLayoutCount = 1;
  layout_info.pSetLayouts = &set_layout_;
  layout_info.pushConstantRangeCount = 1;
  layout_info.pPushConstantRanges = &range;
  vulkan::check(vk.vkCreatePipelineLayout(device, &layout_info, nullptr, &layout_),
                "vkCreatePipelineLayout");
  const std::span<const std::uint32_t> code = spirv::copy_vectors;
  VkShaderModuleCreateInfo module_info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
  module_info.codeSize = code.size_bytes();
  module_info.pCode = code.data();
  VkShaderModule module = VK_NULL_HANDLE;
  vulkan::check(vk.vkCreateShaderModule(device, &module_info, nullptr, &module),
                "vkCreateShaderModule");
  VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
  info.stage = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
  info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  info.stage.module = module;
  info.stage.pName = "main";
  info.layout = layout_;
  const VkResult result =
      vk.vkCreateComputePipelines(device, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline_);
  vk.vkDestroyShaderModule(device, module, nullptr);
  vulkan::check(result, "vkCreateComputePipelines");
}

void DeviceCopy::make_set() {
  const vulkan::DeviceFunctions& vk = machine_.context.vk();
  const VkDevice device = machine_.context.device();
  const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 2};
  VkDescriptorPoolCreateInfo pool_info{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
  pool_info.maxSets = 1;
  pool_info.poolSizeCount = 1;
  pool_info.pPoolSizes = &size;
  vulkan::check(vk.vkCreateDescriptorPool(device, &pool_info, nullptr, &pool_),
                "vkCreateDescriptorPool");
  VkDescriptorSetAllocateInfo set_info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
  set_info.descriptorPool = pool_;
  set_info.descriptorSetCount = 1;
  set_info.pSetLayouts = &set_layout_;
  vulkan::check(vk.vkAllocateDescriptorSets(device, &set_info, &set_), "vkAllocateDescriptorSets");
  const std::array<VkDescriptorBufferInfo, 2> buffers = {
      VkDescriptorBufferInfo{source_.handle(), 0, source_.size()},
      VkDescriptorBufferInfo{target_.handle(), 0, target_.size()}};
  VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
  write.dstSet = set_;
  write.descriptorCount = static_cast<std::uint32_t>(buffers.size());
  write.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
  write.pBufferInfo = buffers.data();
  vk.vkUpdateDescriptorSets(device, 1, &write, 0, nullptr);
}

DeviceCopy::~DeviceCopy() { destroy(); }

void DeviceCopy::destroy() noexcept {
  const vulkan::DeviceFunctions& vk = machine_.context.vk();
  const VkDevice device = machine_.context.device();
  vk.vkDestroyDescriptorPool(device, pool_, nullptr);
  vk.vkDestroyPipeline(device, pipeline_, nullptr);
  vk.vkDestroyPipelineLayout(device, layout_, nullptr);
  vk.vkDestroyDescriptorSetLayout(device, set_layout_, nullptr);
}

void DeviceCopy::record_kernel(VkCommandBuffer commands) const {
  const vulkan::DeviceFunctions& vk = machine_.context.vk();
  const auto count = static_cast<std::uint32_t>(bytes() / kVectorBytes);
  const std::uint32_t groups =
      std::min((count + kCopyLanes - 1) / kCopyLanes, machine_.context.max_group_count());
  vk.vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_);
  vk.vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_, 0, 1, &set_, 0,
                             nullptr);
  vk.vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof count, &count);
  vk.vkCmdDispatch(commands, groups, 1, 1);
}

void DeviceCopy::record_command(VkCommandBuffer commands) const {
  const VkBufferCopy region{0, 0, bytes()};
  machine_.context.vk().vkCmdCopyBuffer(commands, source_.handle(), target_.handle(), 1, &region);
}

bool DeviceCopy::has_copied() {
  bool same = true;
  machine_.submitter.download(whole(target_), [&](std::uint64_t, std::span<const std::byte> piece) {
    for (std::size_t at = 0; at + 4 <= piece.size(); at += 4) {
      std::uint32_t word = 0;
      std::memcpy(&word, &piece[at], sizeof word);
      same = same && word == 0x3f800000;
    }
  });
  machine_.submitter.run([&](VkCommandBuffer commands) {
    machine_.context.vk().vkCmdFillBuffer(commands, target_.handle(), 0, VK_WHOLE_SIZE, 0);
  });
  return same;
}

}  // namespace planish::bench
