#include "planish/vulkan/device/descriptor_sets.h"

#include <array>

#include "planish/core/assert.h"
#include "planish/vulkan/device/arena.h"
#include "planish/vulkan/device/result.h"

namespace planish::vulkan {

DescriptorPool::~DescriptorPool() {
  const DeviceFunctions& vk = context_.vk();
  for (VkBufferView view : views_)
    vk.vkDestroyBufferView(context_.device(), view, context_.callbacks());
  vk.vkDestroyDescriptorPool(context_.device(), pool_, context_.callbacks());
}

std::size_t DescriptorPool::add(std::span<const BoundKernel> kernels) {
  const Pipelines& pipelines = context_.pipelines();
  for (const BoundKernel& kernel : kernels) {
    pipelines.prepare(kernel.kernel);
    PLANISH_ASSERT(kernel.buffers.size() == pipelines[kernel.kernel].bindings.size());
  }
  kernels_.insert(kernels_.end(), kernels.begin(), kernels.end());
  return kernels_.size() - kernels.size();
}

void DescriptorPool::write() {
  if (kernels_.empty()) return;
  allocate();
  for (std::size_t i = 0; i < kernels_.size(); ++i) write(kernels_[i], sets_[i]);
  kernels_ = {};
}

void DescriptorPool::allocate() {
  const Pipelines& pipelines = context_.pipelines();
  VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1},
                                  {VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER, 1}};
  std::vector<VkDescriptorSetLayout> layouts;
  for (const BoundKernel& kernel : kernels_) {
    for (const Binding binding : pipelines[kernel.kernel].bindings) {
      const VkDescriptorType type = descriptor_type(binding, context_.variant().read_path);
      ++sizes[type == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER ? 0 : 1].descriptorCount;
    }
    layouts.push_back(pipelines[kernel.kernel].set_layout);
  }
  const DeviceFunctions& vk = context_.vk();
  VkDescriptorPoolCreateInfo pool{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
  pool.maxSets = static_cast<std::uint32_t>(kernels_.size());
  pool.poolSizeCount = 2;
  pool.pPoolSizes = sizes;
  check(vk.vkCreateDescriptorPool(context_.device(), &pool, context_.callbacks(), &pool_),
        "vkCreateDescriptorPool");
  VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
  allocate.descriptorPool = pool_;
  allocate.descriptorSetCount = pool.maxSets;
  allocate.pSetLayouts = layouts.data();
  sets_.resize(kernels_.size());
  check(vk.vkAllocateDescriptorSets(context_.device(), &allocate, sets_.data()),
        "vkAllocateDescriptorSets");
}

void DescriptorPool::write(const BoundKernel& kernel, VkDescriptorSet set) {
  const std::span<const Binding> bindings = context_.pipelines()[kernel.kernel].bindings;
  std::array<VkDescriptorBufferInfo, kMaxBindings> buffers{};
  std::array<VkBufferView, kMaxBindings> views{};
  std::array<VkWriteDescriptorSet, kMaxBindings> writes{};
  for (std::uint32_t i = 0; i < bindings.size(); ++i) {
    const BufferRange& range = kernel.buffers[i];
    const VkFormat format = texel_format(bindings[i], context_.variant().read_path);
    if (format != VK_FORMAT_UNDEFINED) views[i] = make_view(range, format);
    buffers[i] = {range.buffer, range.offset, range.size};
    writes[i] = {VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
    writes[i].dstSet = set;
    writes[i].dstBinding = i;
    writes[i].descriptorCount = 1;
    writes[i].descriptorType = descriptor_type(bindings[i], context_.variant().read_path);
    writes[i].pBufferInfo = &buffers[i];
    writes[i].pTexelBufferView = &views[i];
  }
  context_.vk().vkUpdateDescriptorSets(
      context_.device(), static_cast<std::uint32_t>(bindings.size()), writes.data(), 0, nullptr);
}

VkBufferView DescriptorPool::make_view(const BufferRange& range, VkFormat format) {
  VkBufferViewCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO};
  info.buffer = range.buffer;
  info.format = format;
  info.offset = range.offset;
  info.range = range.size;
  VkBufferView view = VK_NULL_HANDLE;
  check(context_.vk().vkCreateBufferView(context_.device(), &info, context_.callbacks(), &view),
        "vkCreateBufferView");
  views_.push_back(view);
  return view;
}

DescriptorSets::DescriptorSets(const Maker& on, std::span<const BoundKernel> kernels)
    : pool_(on.arena() ? on.arena()->pool() : std::make_shared<DescriptorPool>(on.context())),
      first_(pool_->add(kernels)) {
  if (!on.arena()) pool_->write();
}

}  // namespace planish::vulkan
