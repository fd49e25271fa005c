#include "planish/vulkan/device/buffer.h"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include "planish/core/error.h"
#include "planish/vulkan/device/result.h"

namespace planish::vulkan {

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
