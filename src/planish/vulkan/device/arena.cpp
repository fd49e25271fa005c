#include "planish/vulkan/device/arena.h"

#include <algorithm>

#include "planish/vulkan/device/result.h"

namespace planish::vulkan {

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

}  // namespace planish::vulkan
