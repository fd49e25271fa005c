#include "planish/vulkan/device/bindings.h"

#include <algorithm>
#include <array>
#include <initializer_list>
#include <memory>
#include <string>
#include <utility>

#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/vulkan/device/driver.h"
#include "shaders/fair/shared_fair.h"
#include "shaders/kernel_code.h"
#include "shaders/shared.h"

namespace planish::vulkan {
namespace {

using enum Binding;

enum class KernelUse { Plain, Special };

KernelSource kernel_source(const char* name, std::span<const std::uint32_t> storage,
                           std::span<const std::uint32_t> texel, KernelUse use,
                           std::uint32_t parameter_bytes, std::initializer_list<Binding> bindings) {
  KernelSource source{name, storage, texel, use == KernelUse::Special, parameter_bytes, {}, 0};
  std::ranges::copy(bindings, source.bindings.begin());
  source.binding_count = static_cast<std::uint32_t>(bindings.size());
  return source;
}

#define PLANISH_TEXTS_Both(file) spirv::file, spirv::file##_texel
#define PLANISH_TEXTS_Once(file) spirv::file, spirv::file
#define PLANISH_KERNEL(texts, use, source, file, name, parameters, ...)        \
  kernel_source("planish " #file, PLANISH_TEXTS_##texts(file), KernelUse::use, \
                sizeof(shared::parameters), {__VA_ARGS__}),

const KernelSource kSources[kKernelCount] = {
#include "planish/vulkan/device/kernels.inc"
};

#undef PLANISH_KERNEL
#undef PLANISH_TEXTS_Once
#undef PLANISH_TEXTS_Both

}  // namespace

const KernelSource& source_of(Kernel kernel) { return kSources[static_cast<std::size_t>(kernel)]; }

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

Arena::~Arena() {
  for (const auto& [block, size] : blocks_) context_.memory().free(block, size);
}

Arena::Piece& Arena::add(VkBuffer buffer, const MemoryRequest& request) {
  return pieces_.emplace_back(Piece{buffer, request});
}

const std::shared_ptr<DescriptorPool>& Arena::pool() {
  if (!pool_) pool_ = std::make_shared<DescriptorPool>(context_);
  return pool_;
}

void Arena::finish() {
  for (const MemoryUse use : {MemoryUse::Device, MemoryUse::Upload, MemoryUse::Download})
    for (auto next = pieces_.begin(); next != pieces_.end();) next = take_block(use, next);
  if (pool_) pool_->write();
}

Arena::Pieces::iterator Arena::take_block(MemoryUse use, Pieces::iterator next) {
  const Capabilities& capabilities = context_.capabilities();
  // What the host flushes starts and ends at whole atoms.
  const VkDeviceSize step = use == MemoryUse::Device ? 1 : capabilities.non_coherent_atom;
  MemoryRequest request{{0, step, ~0u}, use};
  std::vector<std::pair<Piece*, VkDeviceSize>> places;
  for (; next != pieces_.end(); ++next) {
    if (next->request.use != use || !next->buffer) continue;
    const VkMemoryRequirements& needed = next->request.requirements;
    const VkDeviceSize alignment = std::max(needed.alignment, step);
    const VkDeviceSize offset = round_up(request.requirements.size, alignment);
    const VkDeviceSize end = offset + round_up(needed.size, step);
    if (!places.empty() && end > capabilities.max_allocation) break;
    request.requirements.size = end;
    request.requirements.alignment = std::max(request.requirements.alignment, alignment);
    request.requirements.memoryTypeBits &= needed.memoryTypeBits;
    places.emplace_back(&*next, offset);
  }
  if (places.empty()) return next;
  blocks_.reserve(blocks_.size() + 1);
  const MemoryBlock block = context_.memory().allocate(request);
  blocks_.emplace_back(block, request.requirements.size);
  for (const auto& [piece, offset] : places) bind(*piece, block, offset);
  return next;
}

void Arena::bind(Piece& piece, const MemoryBlock& block, VkDeviceSize offset) const {
  piece.memory = block;
  piece.memory.offset += offset;
  if (block.mapped) piece.memory.mapped = static_cast<std::byte*>(block.mapped) + offset;
  check(context_.vk().vkBindBufferMemory(context_.device(), piece.buffer, block.memory,
                                         piece.memory.offset),
        "vkBindBufferMemory");
  if (piece.first_bytes.empty()) return;
  std::ranges::copy(piece.first_bytes, static_cast<std::byte*>(piece.memory.mapped));
  piece.first_bytes = {};
  flush_piece(context_, piece);
}

VkMappedMemoryRange mapped_range(const Context& context, const Arena::Piece& piece) {
  VkMappedMemoryRange range{VK_STRUCTURE_TYPE_MAPPED_MEMORY_RANGE};
  range.memory = piece.memory.memory;
  range.offset = piece.memory.offset;
  range.size = round_up(piece.request.requirements.size, context.capabilities().non_coherent_atom);
  return range;
}

void flush_piece(const Context& context, const Arena::Piece& piece) {
  if (piece.memory.coherent) return;
  const VkMappedMemoryRange range = mapped_range(context, piece);
  check(context.vk().vkFlushMappedMemoryRanges(context.device(), 1, &range),
        "vkFlushMappedMemoryRanges");
}

namespace {

// Bindings need at least one word; empty tables and vectors are allowed.
constexpr std::uint64_t kSmallestBuffer = 16;

}  // namespace

Buffer::Buffer(const Maker& on, std::uint64_t size, MemoryUse use, const char* name)
    : context_(&on.context()), size_(std::max(size, kSmallestBuffer)) {
  Context& context = *context_;
  const Capabilities& capabilities = context.capabilities();
  // Asked before the buffer is made: beyond this limit even vkCreateBuffer is undefined.
  if (size_ > capabilities.max_allocation)
    throw Error(ErrorCode::OutOfMemory,
                formatted("{}: a buffer needs {} bytes, but maxMemoryAllocationSize is {}; use "
                          "--device cpu or a smaller mesh",
                          capabilities.name, size_, capabilities.max_allocation));
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
    if (!on.arena()) own_ = std::make_unique<Arena>(context);
    piece_ = &(own_ ? *own_ : *on.arena()).add(buffer_, request);
    if (own_) own_->finish();
    context.labels().name(VK_OBJECT_TYPE_BUFFER, handle_number(buffer_), name);
  } catch (...) {
    release();
    throw;
  }
}

Buffer make_bindable(const Maker& on, std::uint64_t bytes, const char* name) {
  require_binding(on.context(), bytes, name);
  return Buffer(on, bytes, MemoryUse::Device, name);
}

void require_binding(const Context& context, std::uint64_t bytes, const std::string& what,
                     const std::string& remedy) {
  context.binding_limit().require(bytes, context.capabilities().name + ": " + what, remedy);
}

Buffer& Buffer::operator=(Buffer&& other) noexcept {
  if (this == &other) return *this;
  release();
  context_ = std::exchange(other.context_, nullptr);
  buffer_ = std::exchange(other.buffer_, VK_NULL_HANDLE);
  own_ = std::move(other.own_);
  piece_ = std::exchange(other.piece_, nullptr);
  size_ = std::exchange(other.size_, 0);
  return *this;
}

void Buffer::release() noexcept {
  if (!buffer_) return;
  context_->vk().vkDestroyBuffer(context_->device(), buffer_, context_->callbacks());
  if (piece_) piece_->buffer = VK_NULL_HANDLE;
  own_.reset();
  buffer_ = VK_NULL_HANDLE;
}

std::span<std::byte> Buffer::mapped() const {
  if (!piece_ || !piece_->memory.mapped) return {};
  return {static_cast<std::byte*>(piece_->memory.mapped), static_cast<std::size_t>(size_)};
}

void Buffer::write(std::span<const std::byte> bytes) {
  if (!piece_->memory.memory) {
    piece_->first_bytes.assign(bytes.begin(), bytes.end());
    return;
  }
  std::ranges::copy(bytes, mapped().begin());
  flush();
}

void Buffer::flush() { flush_piece(*context_, *piece_); }

void Buffer::invalidate() {
  if (piece_->memory.coherent) return;
  const VkMappedMemoryRange range = mapped_range(*context_, *piece_);
  check(context_->vk().vkInvalidateMappedMemoryRanges(context_->device(), 1, &range),
        "vkInvalidateMappedMemoryRanges");
}

}  // namespace planish::vulkan
