#include "planish/vulkan/buffer.h"

#include <algorithm>
#include <string>
#include <utility>

#include "planish/core/assert.h"
#include "planish/core/error.h"
#include "planish/vulkan/result.h"

namespace planish::vulkan {

namespace {

// Bindings need at least one word; empty tables and vectors are allowed.
constexpr std::uint64_t kSmallestBuffer = 16;

}  // namespace

Buffer::Buffer(Context& context, std::uint64_t size, MemoryUse use)
    : context_(&context), size_(std::max(size, kSmallestBuffer)) {
  const Capabilities& capabilities = context.capabilities();
  // Asked before the buffer is made: beyond this limit even vkCreateBuffer is undefined.
  if (size_ > capabilities.max_allocation)
    throw Error(ErrorCode::OutOfMemory, capabilities.name + ": a buffer needs " +
                                            std::to_string(size_) +
                                            " bytes, but maxMemoryAllocationSize is " +
                                            std::to_string(capabilities.max_allocation) +
                                            "; use --device cpu or a smaller mesh");
  const DeviceFunctions& vk = context.vk();
  VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
  info.size = size_;
  info.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT |
               VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  check(vk.vkCreateBuffer(context.device(), &info, context.callbacks(), &buffer_),
        "vkCreateBuffer");
  try {
    MemoryRequest request{{}, use};
    vk.vkGetBufferMemoryRequirements(context.device(), buffer_, &request.requirements);
    block_ = context.memory().allocate(request);
    block_size_ = request.requirements.size;
    check(vk.vkBindBufferMemory(context.device(), buffer_, block_.memory, block_.offset),
          "vkBindBufferMemory");
  } catch (...) {
    release();
    throw;
  }
}

Buffer& Buffer::operator=(Buffer&& other) noexcept {
  if (this == &other) return *this;
  release();
  context_ = std::exchange(other.context_, nullptr);
  buffer_ = std::exchange(other.buffer_, VK_NULL_HANDLE);
  block_ = std::exchange(other.block_, {});
  size_ = std::exchange(other.size_, 0);
  block_size_ = std::exchange(other.block_size_, 0);
  return *this;
}

void Buffer::release() noexcept {
  if (!buffer_) return;
  context_->vk().vkDestroyBuffer(context_->device(), buffer_, context_->callbacks());
  if (block_.memory) context_->memory().free(block_, block_size_);
  buffer_ = VK_NULL_HANDLE;
}

std::span<std::byte> Buffer::mapped() const {
  if (!block_.mapped) return {};
  return {static_cast<std::byte*>(block_.mapped), static_cast<std::size_t>(size_)};
}

namespace {

VkMappedMemoryRange mapped_range(const MemoryBlock& block, std::uint64_t size, std::uint64_t atom) {
  VkMappedMemoryRange range{VK_STRUCTURE_TYPE_MAPPED_MEMORY_RANGE};
  range.memory = block.memory;
  range.offset = block.offset;
  // Our own blocks are whole allocations; a host's start and end at multiples of the atom.
  range.size = block.owner ? (size + atom - 1) / atom * atom : VK_WHOLE_SIZE;
  return range;
}

}  // namespace

void Buffer::flush() {
  if (block_.coherent) return;
  const auto range = mapped_range(block_, size_, context_->capabilities().non_coherent_atom);
  check(context_->vk().vkFlushMappedMemoryRanges(context_->device(), 1, &range),
        "vkFlushMappedMemoryRanges");
}

void Buffer::invalidate() {
  if (block_.coherent) return;
  const auto range = mapped_range(block_, size_, context_->capabilities().non_coherent_atom);
  check(context_->vk().vkInvalidateMappedMemoryRanges(context_->device(), 1, &range),
        "vkInvalidateMappedMemoryRanges");
}

DescriptorSets::DescriptorSets(Context& context, std::span<const BoundKernel> kernels)
    : context_(&context) {
  if (kernels.empty()) return;
  const DeviceFunctions& vk = context.vk();
  VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 0};
  std::vector<VkDescriptorSetLayout> layouts;
  for (const BoundKernel& kernel : kernels) {
    PLANISH_ASSERT(kernel.buffers.size() == context.pipelines()[kernel.kernel].binding_count);
    size.descriptorCount += static_cast<std::uint32_t>(kernel.buffers.size());
    layouts.push_back(context.pipelines()[kernel.kernel].set_layout);
  }
  VkDescriptorPoolCreateInfo pool{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
  pool.maxSets = static_cast<std::uint32_t>(kernels.size());
  pool.poolSizeCount = 1;
  pool.pPoolSizes = &size;
  check(vk.vkCreateDescriptorPool(context.device(), &pool, context.callbacks(), &pool_),
        "vkCreateDescriptorPool");
  VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
  allocate.descriptorPool = pool_;
  allocate.descriptorSetCount = pool.maxSets;
  allocate.pSetLayouts = layouts.data();
  sets_.resize(kernels.size());
  const VkResult result = vk.vkAllocateDescriptorSets(context.device(), &allocate, sets_.data());
  if (result != VK_SUCCESS) release();
  check(result, "vkAllocateDescriptorSets");

  for (std::size_t i = 0; i < kernels.size(); ++i) {
    std::vector<VkDescriptorBufferInfo> buffers;
    for (const BufferRange& range : kernels[i].buffers)
      buffers.push_back({range.buffer, range.offset, range.size});
    VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
    write.dstSet = sets_[i];
    write.descriptorCount = static_cast<std::uint32_t>(buffers.size());
    write.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    write.pBufferInfo = buffers.data();
    // One write spills over consecutive bindings of the same type.
    vk.vkUpdateDescriptorSets(context.device(), 1, &write, 0, nullptr);
  }
}

DescriptorSets& DescriptorSets::operator=(DescriptorSets&& other) noexcept {
  if (this == &other) return *this;
  release();
  context_ = std::exchange(other.context_, nullptr);
  pool_ = std::exchange(other.pool_, VK_NULL_HANDLE);
  sets_ = std::move(other.sets_);
  return *this;
}

void DescriptorSets::release() noexcept {
  if (pool_)
    context_->vk().vkDestroyDescriptorPool(context_->device(), pool_, context_->callbacks());
  pool_ = VK_NULL_HANDLE;
}

}  // namespace planish::vulkan
