#include "planish/vulkan/device/memory.h"

#include <algorithm>
#include <string>
#include <utility>

#include "planish/core/error.h"
#include "planish/vulkan/device/result.h"

namespace planish::vulkan {

MemoryAllocator::MemoryAllocator(const DeviceFunctions& functions, VkDevice device,
                                 const Capabilities& capabilities,
                                 const VkAllocationCallbacks* callbacks, MemoryHooks hooks)
    : vk_(functions),
      device_(device),
      capabilities_(capabilities),
      callbacks_(callbacks),
      hooks_(std::move(hooks)) {}

// The first type with the flags wished for most whose heap has room: device memory that the host
// sees too is a small heap of many devices, and may come before their host's.
std::uint32_t MemoryAllocator::pick_type(const MemoryRequest& request) const {
  constexpr VkMemoryPropertyFlags kVisible = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT;
  constexpr VkMemoryPropertyFlags kCoherent = VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  constexpr VkMemoryPropertyFlags kCached = VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
  constexpr VkMemoryPropertyFlags kLocal = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
  const std::initializer_list<VkMemoryPropertyFlags> wishes[] = {
      {kLocal, 0}, {kVisible | kCoherent, kVisible}, {kVisible | kCached, kVisible}};
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
    // Kernels that work in the host's memory are slower than the CPU.
    if (request.use == MemoryUse::Device && !lacking.empty()) break;
  }
  if (lacking.empty())
    throw Error(ErrorCode::OutOfMemory, capabilities_.name + " has no memory type for a buffer");
  throw Error(ErrorCode::OutOfMemory,
              capabilities_.name + ": a buffer needs " + std::to_string(request.requirements.size) +
                  " bytes, but " + lacking + "; use --device cpu or a smaller mesh");
}

std::string MemoryAllocator::lacking_room(std::uint32_t type, std::uint64_t size) const {
  if (size > capabilities_.max_allocation)
    return "maxMemoryAllocationSize is " + std::to_string(capabilities_.max_allocation);
  const std::uint32_t heap = capabilities_.memory.memoryTypes[type].heapIndex;
  const std::uint64_t heap_size = capabilities_.memory.memoryHeaps[heap].size;
  const std::uint64_t taken = heap_bytes_[heap];
  if (taken <= heap_size && size <= heap_size - taken) return "";
  return "memory heap " + std::to_string(heap) + " has " + std::to_string(heap_size) +
         " bytes, of which " + std::to_string(taken) + " are taken";
}

MemoryBlock MemoryAllocator::allocate_own(const MemoryRequest& request) {
  const std::uint32_t type = pick_type(request);
  VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
  info.allocationSize = request.requirements.size;
  info.memoryTypeIndex = type;
  MemoryBlock block;
  check(vk_.vkAllocateMemory(device_, &info, callbacks_, &block.memory), "vkAllocateMemory");
  block.heap = capabilities_.memory.memoryTypes[type].heapIndex;
  block.coherent =
      capabilities_.memory.memoryTypes[type].propertyFlags & VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  if (request.use == MemoryUse::Device) return block;
  const VkResult mapped =
      vk_.vkMapMemory(device_, block.memory, 0, VK_WHOLE_SIZE, 0, &block.mapped);
  if (mapped != VK_SUCCESS) vk_.vkFreeMemory(device_, block.memory, callbacks_);
  check(mapped, "vkMapMemory");
  return block;
}

MemoryBlock MemoryAllocator::allocate_by_hook(const MemoryRequest& request) const {
  const MemoryBlock block = hooks_.allocate(request);
  if (request.use == MemoryUse::Device || block.mapped) return block;
  hooks_.free(block);
  throw Error(ErrorCode::InvalidArgument,
              "MemoryHooks::allocate returned a block for " +
                  std::string(request.use == MemoryUse::Upload ? "Upload" : "Download") +
                  " that is not mapped; set MemoryBlock::mapped");
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
  heap_bytes_[block.heap] += size;
  count(size);
  return block;
}

void MemoryAllocator::free(const MemoryBlock& block, VkDeviceSize size) noexcept {
  if (has_hooks())
    hooks_.free(block);
  else
    vk_.vkFreeMemory(device_, block.memory, callbacks_);
  const std::lock_guard lock(mutex_);
  used_ -= size;
  if (!has_hooks()) heap_bytes_[block.heap] -= size;
}

std::uint64_t MemoryAllocator::peak_bytes() const {
  const std::lock_guard lock(mutex_);
  return peak_;
}

}  // namespace planish::vulkan
