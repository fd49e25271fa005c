#include "planish/vulkan/device/memory.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>

#include "planish/core/error.h"
#include "planish/vulkan/device/result.h"

namespace planish::vulkan {

namespace {

constexpr std::uint64_t kPageBytes = 4u << 20, kLargestInPage = 512u << 10;
constexpr std::uint64_t kPageStep = 256;

std::string_view name_of(MemoryUse use) {
  constexpr std::string_view kNames[] = {"Device", "Upload", "Download"};
  return kNames[static_cast<int>(use)];
}

// What a host's block lacks, and what to do; empty where it serves.
std::string lack_of(const MemoryBlock& block, const MemoryRequest& request) {
  const VkMemoryRequirements& needed = request.requirements;
  if (!block.memory)
    return "without memory; set MemoryBlock::memory, or throw Error{OutOfMemory} where there is "
           "none";
  if (block.offset % needed.alignment != 0)
    return formatted(
        "at MemoryBlock::offset {}, which is no multiple of {}; take "
        "MemoryRequest::requirements.alignment",
        block.offset, needed.alignment);
  if (block.size != 0 && block.size < needed.size)
    return formatted(
        "of MemoryBlock::size {}, but {} bytes are needed; take MemoryRequest::requirements.size",
        block.size, needed.size);
  if (request.use != MemoryUse::Device && !block.mapped)
    return "that is not mapped; set MemoryBlock::mapped";
  return "";
}

}  // namespace

/// Blocks one after another; room comes back when the last of them has gone.
struct MemoryAllocator::Page {
  MemoryBlock memory;
  std::uint32_t type = 0;
  std::uint64_t end = 0;
  std::size_t block_count = 0;
};

MemoryAllocator::MemoryAllocator(const DeviceFunctions& functions, VkDevice device,
                                 const Capabilities& capabilities,
                                 const VkAllocationCallbacks* callbacks, MemoryHooks hooks,
                                 bool has_addresses)
    : vk_(functions),
      device_(device),
      capabilities_(capabilities),
      callbacks_(callbacks),
      hooks_(std::move(hooks)),
      has_addresses_(has_addresses) {}

MemoryAllocator::~MemoryAllocator() = default;

// The first type with the flags wished for most whose heap has room: device memory that the host
// sees too is a small heap of many devices, and may come before their host's. For kernels nothing
// else will do: Vulkan promises device memory for every buffer, and in the host's they are slower
// than the CPU.
std::uint32_t MemoryAllocator::pick_type(const MemoryRequest& request) const {
  constexpr VkMemoryPropertyFlags kVisible = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT;
  constexpr VkMemoryPropertyFlags kCoherent = VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  constexpr VkMemoryPropertyFlags kCached = VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
  constexpr VkMemoryPropertyFlags kLocal = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
  const std::initializer_list<VkMemoryPropertyFlags> wishes[] = {
      {kLocal}, {kVisible | kCoherent, kVisible}, {kVisible | kCached, kVisible}};
  const VkPhysicalDeviceMemoryProperties& memory = capabilities_.memory;
  std::string lacking;
  for (const VkMemoryPropertyFlags wish : wishes[static_cast<int>(request.use)]) {
    for (std::uint32_t i = 0; i < memory.memoryTypeCount; ++i) {
      if ((request.requirements.memoryTypeBits >> i & 1u) == 0) continue;
      if ((memory.memoryTypes[i].propertyFlags & wish) != wish) continue;
      const std::string reason = lacking_room(i, request.requirements.size);
      if (reason.empty()) return i;
      if (lacking.empty()) lacking = reason;
    }
  }
  if (lacking.empty())
    throw Error(ErrorCode::OutOfMemory, capabilities_.name + " has no memory type for a buffer");
  throw Error(ErrorCode::OutOfMemory,
              formatted("{}: a buffer needs {} bytes, but {}; use --device cpu or a smaller mesh",
                        capabilities_.name, request.requirements.size, lacking));
}

std::string MemoryAllocator::lacking_room(std::uint32_t type, std::uint64_t size) const {
  if (size > capabilities_.max_allocation)
    return formatted("maxMemoryAllocationSize is {}", capabilities_.max_allocation);
  const std::uint32_t heap = capabilities_.memory.memoryTypes[type].heapIndex;
  const std::uint64_t heap_size = capabilities_.memory.memoryHeaps[heap].size;
  const std::uint64_t taken = heap_bytes_[heap];
  if (taken <= heap_size && size <= heap_size - taken) return "";
  return formatted("memory heap {} has {} bytes, of which {} are taken", heap, heap_size, taken);
}

MemoryBlock MemoryAllocator::take(std::uint32_t type, std::uint64_t size, bool is_mapped) {
  VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
  info.allocationSize = size;
  info.memoryTypeIndex = type;
  VkMemoryAllocateFlagsInfo flags{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO};
  flags.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT;
  if (has_addresses_) info.pNext = &flags;
  MemoryBlock block;
  check(vk_.vkAllocateMemory(device_, &info, callbacks_, &block.memory), "vkAllocateMemory");
  block.heap = capabilities_.memory.memoryTypes[type].heapIndex;
  block.coherent =
      capabilities_.memory.memoryTypes[type].propertyFlags & VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  if (is_mapped) {
    const VkResult mapped =
        vk_.vkMapMemory(device_, block.memory, 0, VK_WHOLE_SIZE, 0, &block.mapped);
    if (mapped != VK_SUCCESS) vk_.vkFreeMemory(device_, block.memory, callbacks_);
    check(mapped, "vkMapMemory");
  }
  heap_bytes_[block.heap] += size;
  return block;
}

void MemoryAllocator::give_back(const MemoryBlock& block, std::uint64_t size) noexcept {
  vk_.vkFreeMemory(device_, block.memory, callbacks_);
  heap_bytes_[block.heap] -= size;
}

MemoryBlock MemoryAllocator::from_page(const MemoryRequest& request, std::uint32_t type) {
  const bool is_mapped = request.use != MemoryUse::Device;
  // Blocks of their own atoms, which flushing and invalidating takes whole.
  const std::uint64_t step =
      std::max({request.requirements.alignment, capabilities_.non_coherent_atom, kPageStep});
  const std::uint64_t size = round_up(request.requirements.size, step);
  const auto fits = [&](const std::unique_ptr<Page>& page) {
    return page->type == type && (page->memory.mapped != nullptr) == is_mapped &&
           round_up(page->end, step) + size <= kPageBytes;
  };
  auto found = std::ranges::find_if(pages_, fits);
  if (found == pages_.end()) {
    if (!lacking_room(type, kPageBytes).empty()) return {};
    auto page = std::make_unique<Page>();
    pages_.reserve(pages_.size() + 1);
    page->memory = take(type, kPageBytes, is_mapped);
    page->type = type;
    pages_.push_back(std::move(page));
    found = pages_.end() - 1;
  }
  Page& page = **found;
  MemoryBlock block = page.memory;
  block.offset = round_up(page.end, step);
  if (is_mapped) block.mapped = static_cast<std::byte*>(page.memory.mapped) + block.offset;
  block.owner = &page;
  page.end = block.offset + size;
  ++page.block_count;
  return block;
}

MemoryBlock MemoryAllocator::allocate_own(const MemoryRequest& request) {
  const std::uint32_t type = pick_type(request);
  if (request.requirements.size <= kLargestInPage) {
    const MemoryBlock block = from_page(request, type);
    if (block.memory) return block;
  }
  return take(type, request.requirements.size, request.use != MemoryUse::Device);
}

MemoryBlock MemoryAllocator::allocate_by_hook(const MemoryRequest& request) const {
  const MemoryBlock block = hooks_.allocate(request);
  const std::string lack = lack_of(block, request);
  if (lack.empty()) return block;
  if (block.memory) hooks_.free(block);
  throw Error(
      ErrorCode::InvalidArgument,
      formatted("MemoryHooks::allocate returned a block for {} {}", name_of(request.use), lack));
}

void MemoryAllocator::count(std::uint64_t size) {
  used_ += size;
  peak_ = std::max(peak_, used_);
}

// A hook may take the host's lock, under which the host may make objects of planish's: ours is
// never held while it runs.
MemoryBlock MemoryAllocator::allocate(const MemoryRequest& request) {
  const std::uint64_t size = request.requirements.size;
  if (has_hooks()) {
    const MemoryBlock block = allocate_by_hook(request);
    const std::lock_guard lock(mutex_);
    count(size);
    return block;
  }
  const std::lock_guard lock(mutex_);
  const MemoryBlock block = allocate_own(request);
  count(size);
  return block;
}

void MemoryAllocator::free(const MemoryBlock& block, VkDeviceSize size) noexcept {
  if (has_hooks()) hooks_.free(block);
  const std::lock_guard lock(mutex_);
  used_ -= size;
  if (has_hooks()) return;
  if (!block.owner) {
    give_back(block, size);
    return;
  }
  Page& page = *static_cast<Page*>(block.owner);
  if (--page.block_count > 0) return;
  give_back(page.memory, kPageBytes);
  std::erase_if(pages_, [&](const std::unique_ptr<Page>& of) { return of.get() == &page; });
}

std::uint64_t MemoryAllocator::peak_bytes() const {
  const std::lock_guard lock(mutex_);
  return peak_;
}

}  // namespace planish::vulkan
