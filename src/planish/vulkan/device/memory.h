#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "planish/vulkan/device/capabilities.h"
#include "planish/vulkan/device/functions.h"

namespace planish::vulkan {

/// The first multiple of `step` that is not below `value`.
[[nodiscard]] constexpr std::uint64_t round_up(std::uint64_t value, std::uint64_t step) {
  return (value + step - 1) / step * step;
}

/// What a buffer's memory is for.
enum class MemoryUse {
  Device,    ///< read and written by kernels only
  Upload,    ///< written by the host, mapped
  Download,  ///< read by the host, mapped, cached where possible
};

struct MemoryRequest {
  VkMemoryRequirements requirements;
  MemoryUse use;
};

/// A piece of device memory. `mapped` is null for MemoryUse::Device.
struct MemoryBlock {
  VkDeviceMemory memory = VK_NULL_HANDLE;
  VkDeviceSize offset = 0;
  void* mapped = nullptr;
  bool coherent = true;    ///< false: planish flushes and invalidates [offset, offset + size)
  void* owner = nullptr;   ///< the host allocator's own handle, if any; without hooks: the page
  std::uint32_t heap = 0;  ///< without hooks: the heap that it is taken from
  VkDeviceSize size = 0;   ///< bytes from `offset` on; 0: as many as were requested
};

/// How a host's allocator serves every allocation, of which an object has one for each MemoryUse.
/// Both or neither are set. They are called without a lock of planish's, from any thread that makes
/// or destroys objects. `allocate` may throw planish::Error, `free` nothing. A block has memory,
/// begins at a multiple of the requested alignment, and is mapped for Upload and Download, which
/// are requested in whole multiples of nonCoherentAtomSize: one that is not so is freed again, and
/// Error{InvalidArgument} says what it lacks.
struct MemoryHooks {
  std::function<MemoryBlock(const MemoryRequest&)> allocate;
  std::function<void(const MemoryBlock&)> free;
};

/// Gives memory to arenas, by the hooks or by vkAllocateMemory, and counts it. Small blocks share
/// an allocation, a page: devices need not allow more than 4096. Thread-safe.
class MemoryAllocator {
 public:
  MemoryAllocator(const DeviceFunctions& functions, VkDevice device,
                  const Capabilities& capabilities, const VkAllocationCallbacks* callbacks,
                  MemoryHooks hooks, bool has_addresses);
  ~MemoryAllocator();

  /// Throws Error{OutOfMemory} before taking memory that a heap or limit does not allow, naming
  /// it.
  [[nodiscard]] MemoryBlock allocate(const MemoryRequest& request);
  void free(const MemoryBlock& block, VkDeviceSize size) noexcept;

  [[nodiscard]] std::uint64_t peak_bytes() const;
  [[nodiscard]] bool has_hooks() const { return static_cast<bool>(hooks_.allocate); }

 private:
  [[nodiscard]] std::uint32_t pick_type(const MemoryRequest& request) const;
  /// Why so many bytes of a type cannot be had; empty if they can.
  [[nodiscard]] std::string lacking_room(std::uint32_t type, std::uint64_t size) const;
  struct Page;
  [[nodiscard]] MemoryBlock allocate_own(const MemoryRequest& request);
  /// A whole VkDeviceMemory.
  [[nodiscard]] MemoryBlock take(std::uint32_t type, std::uint64_t size, bool is_mapped);
  void give_back(const MemoryBlock& block, std::uint64_t size) noexcept;
  /// From a page of the type, made if need be; without memory where a heap has no room for one.
  [[nodiscard]] MemoryBlock from_page(const MemoryRequest& request, std::uint32_t type);
  /// Throws Error{InvalidArgument} for a block that cannot serve the request, once it is freed.
  [[nodiscard]] MemoryBlock allocate_by_hook(const MemoryRequest& request) const;
  void count(std::uint64_t size);  // under the lock

  const DeviceFunctions& vk_;
  VkDevice device_;
  const Capabilities& capabilities_;
  const VkAllocationCallbacks* callbacks_;
  MemoryHooks hooks_;
  bool has_addresses_;  // shaders may know where buffers are
  mutable std::mutex mutex_;
  std::array<std::uint64_t, VK_MAX_MEMORY_HEAPS> heap_bytes_{};  // taken without hooks
  std::vector<std::unique_ptr<Page>> pages_;
  std::uint64_t used_ = 0;
  std::uint64_t peak_ = 0;
};

}  // namespace planish::vulkan
