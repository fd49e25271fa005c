#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "planish/vulkan/device/arena.h"
#include "planish/vulkan/device/context.h"
#include "planish/vulkan/device/descriptor_sets.h"

namespace planish::vulkan {

/// A buffer with its memory, usable as storage and for copies. What made it outlives it.
class Buffer {
 public:
  Buffer() = default;
  /// At least `size` bytes; `name` is for debuggers. Throws Error{OutOfMemory}, naming the limit.
  Buffer(const Maker& on, std::uint64_t size, MemoryUse use, const char* name = nullptr);
  ~Buffer() { release(); }
  Buffer(Buffer&& other) noexcept { *this = std::move(other); }
  Buffer& operator=(Buffer&& other) noexcept;

  [[nodiscard]] VkBuffer handle() const { return buffer_; }
  [[nodiscard]] std::uint64_t size() const { return size_; }
  /// The host's view of it; empty for MemoryUse::Device.
  [[nodiscard]] std::span<std::byte> mapped() const;
  /// The first bytes of it, visible to the device; also before an Arena is finished, once.
  void write(std::span<const std::byte> bytes);
  /// Makes the host's writes visible to the device, before the submission that reads them.
  void flush();
  /// Makes the device's writes visible to the host, after the wait.
  void invalidate();

 private:
  void release() noexcept;

  Context* context_ = nullptr;
  VkBuffer buffer_ = VK_NULL_HANDLE;
  std::unique_ptr<Arena> own_;  // where a Context made it
  Arena::Piece* piece_ = nullptr;
  std::uint64_t size_ = 0;
};

/// A buffer that one binding spans, in device memory. Throws Error{OutOfMemory} naming the limit
/// that it exceeds.
[[nodiscard]] Buffer make_bindable(const Maker& on, std::uint64_t bytes, const char* name);

/// The same for bytes of any buffer.
void require_binding(const Context& context, std::uint64_t bytes, const std::string& what,
                     const std::string& remedy = kSmallerMesh);

/// A multiple of every alignment that Vulkan allows a device to ask of a binding's offset.
inline constexpr VkDeviceSize kBindingAlignment = 256;

[[nodiscard]] inline BufferRange whole(const Buffer& buffer) {
  return {buffer.handle(), 0, buffer.size()};
}

}  // namespace planish::vulkan
