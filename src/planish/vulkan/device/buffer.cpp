#include "planish/vulkan/device/buffer.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "planish/core/assert.h"
#include "planish/core/error.h"
#include "planish/vulkan/device/result.h"

namespace planish::vulkan {

namespace {

// Bindings need at least one word; empty tables and vectors are allowed.
constexpr std::uint64_t kSmallestBuffer = 16;

}  // namespace

Buffer::Buffer(Context& context, std::uint64_t size, MemoryUse use, const char* name)
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
  info.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT |
               VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT | VK_BUFFER_USAGE_VERTEX_BUFFER_BIT |
               VK_BUFFER_USAGE_INDEX_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT |
               VK_BUFFER_USAGE_TRANSFER_DST_BIT | context.further_usage();
  check(vk.vkCreateBuffer(context.device(), &info, context.callbacks(), &buffer_),
        "vkCreateBuffer");
  try {
    MemoryRequest request{{}, use};
    vk.vkGetBufferMemoryRequirements(context.device(), buffer_, &request.requirements);
    block_ = context.memory().allocate(request);
    block_size_ = request.requirements.size;
    check(vk.vkBindBufferMemory(context.device(), buffer_, block_.memory, block_.offset),
          "vkBindBufferMemory");
    context.labels().name(VK_OBJECT_TYPE_BUFFER, handle_number(buffer_), name);
  } catch (...) {
    release();
    throw;
  }
}

Buffer make_bindable(Context& context, std::uint64_t bytes, const char* name) {
  if (bytes > context.max_storage_range())
    throw Error(ErrorCode::OutOfMemory, context.capabilities().name + ": " + std::to_string(bytes) +
                                            " bytes are needed in one binding (" + name +
                                            "), but maxStorageBufferRange is " +
                                            std::to_string(context.max_storage_range()) +
                                            "; use --device cpu or a smaller mesh");
  return Buffer(context, bytes, MemoryUse::Device, name);
}

void require_one_binding(const Context& context, std::uint64_t bytes, std::uint64_t texel_bytes,
                         const char* what) {
  const auto refuse = [&](const std::string& limit, std::uint64_t value) {
    throw Error(ErrorCode::OutOfMemory, context.capabilities().name + ": " + what + " take " +
                                            std::to_string(bytes) + " bytes, which are bound as " +
                                            "one, but " + limit + " is " + std::to_string(value) +
                                            "; use a smaller mesh or fewer instances");
  };
  if (bytes > context.max_storage_range())
    refuse("maxStorageBufferRange", context.max_storage_range());
  if (texel_bytes > 0 && bytes / texel_bytes > context.max_texel_elements())
    refuse("maxTexelBufferElements", context.max_texel_elements());
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

VkMappedMemoryRange mapped_range(Context& context, const MemoryBlock& block, std::uint64_t size) {
  const std::uint64_t atom = context.capabilities().non_coherent_atom;
  VkMappedMemoryRange range{VK_STRUCTURE_TYPE_MAPPED_MEMORY_RANGE};
  range.memory = block.memory;
  range.offset = block.offset;
  // Whole allocations need not be multiples of the atom; blocks that others lie beside start and
  // end at multiples of it.
  range.size = context.memory().is_shared(block) ? (size + atom - 1) / atom * atom : VK_WHOLE_SIZE;
  return range;
}

}  // namespace

void Buffer::flush() {
  if (block_.coherent) return;
  const auto range = mapped_range(*context_, block_, size_);
  check(context_->vk().vkFlushMappedMemoryRanges(context_->device(), 1, &range),
        "vkFlushMappedMemoryRanges");
}

void Buffer::invalidate() {
  if (block_.coherent) return;
  const auto range = mapped_range(*context_, block_, size_);
  check(context_->vk().vkInvalidateMappedMemoryRanges(context_->device(), 1, &range),
        "vkInvalidateMappedMemoryRanges");
}

DescriptorSets::DescriptorSets(Context& context, std::span<const BoundKernel> kernels)
    : context_(&context) {
  if (kernels.empty()) return;
  try {
    allocate(kernels);
    for (std::size_t i = 0; i < kernels.size(); ++i) write(kernels[i], sets_[i]);
  } catch (...) {
    release();
    throw;
  }
}

void DescriptorSets::allocate(std::span<const BoundKernel> kernels) {
  const Pipelines& pipelines = context_->pipelines();
  VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1},
                                  {VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER, 1}};
  std::vector<VkDescriptorSetLayout> layouts;
  for (const BoundKernel& kernel : kernels) {
    pipelines.prepare(kernel.kernel);
    const std::span<const Binding> bindings = pipelines[kernel.kernel].bindings;
    PLANISH_ASSERT(kernel.buffers.size() == bindings.size());
    for (const Binding binding : bindings) {
      const VkDescriptorType type = descriptor_type(binding, context_->variant().read_path);
      ++sizes[type == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER ? 0 : 1].descriptorCount;
    }
    layouts.push_back(pipelines[kernel.kernel].set_layout);
  }
  const DeviceFunctions& vk = context_->vk();
  VkDescriptorPoolCreateInfo pool{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
  pool.maxSets = static_cast<std::uint32_t>(kernels.size());
  pool.poolSizeCount = 2;
  pool.pPoolSizes = sizes;
  check(vk.vkCreateDescriptorPool(context_->device(), &pool, context_->callbacks(), &pool_),
        "vkCreateDescriptorPool");
  VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
  allocate.descriptorPool = pool_;
  allocate.descriptorSetCount = pool.maxSets;
  allocate.pSetLayouts = layouts.data();
  sets_.resize(kernels.size());
  check(vk.vkAllocateDescriptorSets(context_->device(), &allocate, sets_.data()),
        "vkAllocateDescriptorSets");
}

void DescriptorSets::write(const BoundKernel& kernel, VkDescriptorSet set) {
  const std::span<const Binding> bindings = context_->pipelines()[kernel.kernel].bindings;
  std::array<VkDescriptorBufferInfo, kMaxBindings> buffers{};
  std::array<VkBufferView, kMaxBindings> views{};
  std::array<VkWriteDescriptorSet, kMaxBindings> writes{};
  for (std::uint32_t i = 0; i < bindings.size(); ++i) {
    const BufferRange& range = kernel.buffers[i];
    const VkFormat format = texel_format(bindings[i], context_->variant().read_path);
    if (format != VK_FORMAT_UNDEFINED) views[i] = make_view(range, format);
    buffers[i] = {range.buffer, range.offset, range.size};
    writes[i] = {VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
    writes[i].dstSet = set;
    writes[i].dstBinding = i;
    writes[i].descriptorCount = 1;
    writes[i].descriptorType = descriptor_type(bindings[i], context_->variant().read_path);
    writes[i].pBufferInfo = &buffers[i];
    writes[i].pTexelBufferView = &views[i];
  }
  context_->vk().vkUpdateDescriptorSets(
      context_->device(), static_cast<std::uint32_t>(bindings.size()), writes.data(), 0, nullptr);
}

VkBufferView DescriptorSets::make_view(const BufferRange& range, VkFormat format) {
  VkBufferViewCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO};
  info.buffer = range.buffer;
  info.format = format;
  info.offset = range.offset;
  info.range = range.size;
  VkBufferView view = VK_NULL_HANDLE;
  check(context_->vk().vkCreateBufferView(context_->device(), &info, context_->callbacks(), &view),
        "vkCreateBufferView");
  views_.push_back(view);
  return view;
}

DescriptorSets& DescriptorSets::operator=(DescriptorSets&& other) noexcept {
  if (this == &other) return *this;
  release();
  context_ = std::exchange(other.context_, nullptr);
  pool_ = std::exchange(other.pool_, VK_NULL_HANDLE);
  sets_ = std::move(other.sets_);
  views_ = std::move(other.views_);
  return *this;
}

void DescriptorSets::release() noexcept {
  if (!context_) return;
  const DeviceFunctions& vk = context_->vk();
  for (VkBufferView view : views_)
    vk.vkDestroyBufferView(context_->device(), view, context_->callbacks());
  vk.vkDestroyDescriptorPool(context_->device(), pool_, context_->callbacks());
  views_.clear();
  pool_ = VK_NULL_HANDLE;
}

}  // namespace planish::vulkan
