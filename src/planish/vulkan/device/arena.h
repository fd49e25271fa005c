#pragma once

#include <cstddef>
#include <list>
#include <memory>
#include <utility>
#include <vector>

#include "planish/vulkan/device/context.h"
#include "planish/vulkan/device/descriptor_sets.h"

namespace planish::vulkan {

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

}  // namespace planish::vulkan
