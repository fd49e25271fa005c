#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "planish/vulkan/device/context.h"

namespace planish::vulkan {

enum class Kernel : std::uint32_t {
#define PLANISH_KERNEL(texts, use, source, file, name, ...) name,
#include "planish/vulkan/device/kernels.inc"
#undef PLANISH_KERNEL
};

#define PLANISH_KERNEL(...) +1
inline constexpr std::size_t kKernelCount = 0
#include "planish/vulkan/device/kernels.inc"
    ;
#undef PLANISH_KERNEL

/// Bindings of the kernel with the most of them.
inline constexpr std::uint32_t kMaxBindings = 8;

/// A kernel's SPIR-V, reading storage buffers or texel buffers, and what it is bound to.
struct KernelSource {
  const char* name;  ///< of its file, for debuggers
  std::span<const std::uint32_t> storage, texel;
  bool is_special;  ///< compiled by Pipelines::specialised() only
  std::uint32_t parameter_bytes;
  std::array<Binding, kMaxBindings> bindings;
  std::uint32_t binding_count;
};

[[nodiscard]] const KernelSource& source_of(Kernel kernel);

class Maker;

/// A piece of a buffer, as a binding sees it.
struct BufferRange {
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceSize offset = 0;
  VkDeviceSize size = VK_WHOLE_SIZE;
};

/// The buffers of one kernel's bindings, in order.
struct BoundKernel {
  Kernel kernel;
  std::vector<BufferRange> buffers;
};

/// A VkDescriptorPool with a set for each kernel that was added, all written at once.
class DescriptorPool {
 public:
  explicit DescriptorPool(Context& context) : context_(context) {}
  ~DescriptorPool();
  DescriptorPool(const DescriptorPool&) = delete;
  DescriptorPool& operator=(const DescriptorPool&) = delete;

  /// Compiles kernels that are not special. Returns the number of the first one's set.
  std::size_t add(std::span<const BoundKernel> kernels);
  /// Makes and writes the sets, once, when the buffers have their memory. Throws planish::Error.
  void write();
  [[nodiscard]] VkDescriptorSet operator[](std::size_t i) const { return sets_[i]; }

 private:
  void allocate();
  void write(const BoundKernel& kernel, VkDescriptorSet set);
  [[nodiscard]] VkBufferView make_view(const BufferRange& range, VkFormat format);

  Context& context_;
  std::vector<BoundKernel> kernels_;  // until they are written
  VkDescriptorPool pool_ = VK_NULL_HANDLE;
  std::vector<VkDescriptorSet> sets_;
  std::vector<VkBufferView> views_;
};

/// Sets of a pool of their own, or of an Arena's.
class DescriptorSets {
 public:
  DescriptorSets() = default;
  DescriptorSets(const Maker& on, std::span<const BoundKernel> kernels);
  [[nodiscard]] VkDescriptorSet operator[](std::size_t i) const { return (*pool_)[first_ + i]; }

 private:
  std::shared_ptr<DescriptorPool> pool_;
  std::size_t first_ = 0;
};

/// The memory and the descriptor sets of an object's buffers: one block for each MemoryUse and one
/// pool, taken when all sizes are known. Outlives what it makes.
class Arena {
 public:
  explicit Arena(Context& context) : context_(context) {}
  ~Arena();
  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;

  /// Takes the memory, more blocks than one only beyond maxMemoryAllocationSize, and writes what
  /// Buffer::write() was given and all sets. Nothing is made of the arena afterwards. Throws
  /// Error{OutOfMemory} naming the limit.
  void finish();

  /// What a Buffer keeps here.
  struct Piece {
    VkBuffer buffer;
    MemoryRequest request;
    MemoryBlock memory{};  ///< once the arena is finished
    std::vector<std::byte> first_bytes{};
  };
  Piece& add(VkBuffer buffer, const MemoryRequest& request);
  [[nodiscard]] Context& context() const { return context_; }
  [[nodiscard]] const std::shared_ptr<DescriptorPool>& pool();

 private:
  using Pieces = std::list<Piece>;  // which stay where they are
  /// One block for as many pieces from `next` on as it holds; returns the first one that is left.
  Pieces::iterator take_block(MemoryUse use, Pieces::iterator next);
  void bind(Piece& piece, const MemoryBlock& block, VkDeviceSize offset) const;

  Context& context_;
  Pieces pieces_;
  std::vector<std::pair<MemoryBlock, VkDeviceSize>> blocks_;  // with their sizes
  std::shared_ptr<DescriptorPool> pool_;                      // where there are sets
};

/// The whole atoms that a mapped piece takes.
[[nodiscard]] VkMappedMemoryRange mapped_range(const Context& context, const Arena::Piece& piece);
/// Makes the host's writes visible to the device.
void flush_piece(const Context& context, const Arena::Piece& piece);

/// What buffers and sets are made by: a Context, each by itself, or an Arena, all together.
class Maker {
 public:
  Maker(Context& context) : context_(context) {}
  Maker(Arena& arena) : context_(arena.context()), arena_(&arena) {}
  [[nodiscard]] Context& context() const { return context_; }
  [[nodiscard]] Arena* arena() const { return arena_; }

 private:
  Context& context_;
  Arena* arena_ = nullptr;
};

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
