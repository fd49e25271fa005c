#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "planish/vulkan/device/context.h"
#include "planish/vulkan/device/kernels.h"

namespace planish::vulkan {

/// A buffer with its memory, usable as storage and for copies. Its Context outlives it.
class Buffer {
 public:
  Buffer() = default;
  /// At least `size` bytes; `name` is for debuggers. Throws Error{OutOfMemory}, naming the limit.
  Buffer(Context& context, std::uint64_t size, MemoryUse use, const char* name = nullptr);
  ~Buffer() { release(); }
  Buffer(Buffer&& other) noexcept { *this = std::move(other); }
  Buffer& operator=(Buffer&& other) noexcept;

  [[nodiscard]] VkBuffer handle() const { return buffer_; }
  [[nodiscard]] std::uint64_t size() const { return size_; }
  /// The host's view of it; empty for MemoryUse::Device.
  [[nodiscard]] std::span<std::byte> mapped() const;
  /// Makes the host's writes visible to the device, before the submission that reads them.
  void flush();
  /// Makes the device's writes visible to the host, after the wait.
  void invalidate();

 private:
  void release() noexcept;

  Context* context_ = nullptr;
  VkBuffer buffer_ = VK_NULL_HANDLE;
  MemoryBlock block_;
  std::uint64_t size_ = 0;
  std::uint64_t block_size_ = 0;
};

/// A buffer that one binding spans, in device memory. Throws Error{OutOfMemory} naming the limit
/// that it exceeds.
[[nodiscard]] Buffer make_bindable(Context& context, std::uint64_t bytes, const char* name);

/// Throws Error{OutOfMemory} where a device has no binding of so many bytes, read by texels of
/// `texel_bytes` (0: as words that kernels write), naming `what` and the limit.
void require_one_binding(const Context& context, std::uint64_t bytes, std::uint64_t texel_bytes,
                         const char* what);

/// A multiple of every alignment that Vulkan allows a device to ask of a binding's offset.
inline constexpr VkDeviceSize kBindingAlignment = 256;

/// A piece of a buffer, as a binding sees it.
struct BufferRange {
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceSize offset = 0;
  VkDeviceSize size = VK_WHOLE_SIZE;
};
[[nodiscard]] inline BufferRange whole(const Buffer& buffer) {
  return {buffer.handle(), 0, buffer.size()};
}

/// The buffers of one kernel's bindings, in order.
struct BoundKernel {
  Kernel kernel;
  std::vector<BufferRange> buffers;
};

/// Descriptor sets, allocated and written once. Their kernels are compiled, but for special ones.
class DescriptorSets {
 public:
  DescriptorSets() = default;
  DescriptorSets(Context& context, std::span<const BoundKernel> kernels);
  ~DescriptorSets() { release(); }
  DescriptorSets(DescriptorSets&& other) noexcept { *this = std::move(other); }
  DescriptorSets& operator=(DescriptorSets&& other) noexcept;

  [[nodiscard]] VkDescriptorSet operator[](std::size_t i) const { return sets_[i]; }

 private:
  void allocate(std::span<const BoundKernel> kernels);
  void write(const BoundKernel& kernel, VkDescriptorSet set);
  [[nodiscard]] VkBufferView make_view(const BufferRange& range, VkFormat format);
  void release() noexcept;

  Context* context_ = nullptr;
  VkDescriptorPool pool_ = VK_NULL_HANDLE;
  std::vector<VkDescriptorSet> sets_;
  std::vector<VkBufferView> views_;
};

}  // namespace planish::vulkan
