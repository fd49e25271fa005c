#include "planish/vulkan/device/memory.h"

#include <algorithm>
#include <string>
#include <utility>

#include "planish/core/error.h"
#include "planish/vulkan/device/result.h"

namespace planish::vulkan {

namespace {

constexpr std::uint32_t kNoType = ~0u;

/// First type among `allowed` that has all of `flags`.
std::uint32_t find_type(const VkPhysicalDeviceMemoryProperties& memory, std::uint32_t allowed,
                        VkMemoryPropertyFlags flags) {
  for (std::uint32_t i = 0; i < memory.memoryTypeCount; ++i)
    if ((allowed >> i & 1u) && (memory.memoryTypes[i].propertyFlags & flags) == flags) return i;
  return kNoType;
}

}  // namespace

MemoryAllocator::MemoryAllocator(const DeviceFunctions& functions, VkDevice device,
                                 const Capabilities& capabilities,
                                 const VkAllocationCallbacks* callbacks, MemoryHooks hooks)
    : vk_(functions),
      device_(device),
      capabilities_(capabilities),
      callbacks_(callbacks),
      hooks_(std::move(hooks)) {}

std::uint32_t MemoryAllocator::pick_type(const MemoryRequest& request) const {
  constexpr VkMemoryPropertyFlags kVisible = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT;
  constexpr VkMemoryPropertyFlags kCoherent = VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  constexpr VkMemoryPropertyFlags kCached = VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
  constexpr VkMemoryPropertyFlags kLocal = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
  const std::initializer_list<VkMemoryPropertyFlags> wishes[] = {
      {kLocal, 0}, {kVisible | kCoherent, kVisible}, {kVisible | kCached, kVisible}};
  for (const VkMemoryPropertyFlags wish : wishes[static_cast<int>(request.use)]) {
    const std::uint32_t type =
        find_type(capabilities_.memory, request.requirements.memoryTypeBits, wish);
    if (type != kNoType) return type;
  }
  throw Error(ErrorCode::OutOfMemory, capabilities_.name + " has no memory type for a buffer");
}

void MemoryAllocator::check_room(std::uint32_t type, std::uint64_t size) const {
  const std::uint32_t heap = capabilities_.memory.memoryTypes[type].heapIndex;
  const std::uint64_t heap_size = capabilities_.memory.memoryHeaps[heap].size;
  std::string limit;
  if (size > capabilities_.max_allocation)
    limit = "maxMemoryAllocationSize is " + std::to_string(capabilities_.max_allocation);
  else if (used_ > heap_size || size > heap_size - used_)
    limit = "memory heap " + std::to_string(heap) + " has " + std::to_string(heap_size) +
            " bytes, of which " + std::to_string(used_) + " are taken";
  if (!limit.empty())
    throw Error(ErrorCode::OutOfMemory, capabilities_.name + ": a buffer needs " +
                                            std::to_string(size) + " bytes, but " + limit +
                                            "; use --device cpu or a smaller mesh");
}

MemoryBlock MemoryAllocator::allocate_own(const MemoryRequest& request) {
  const std::uint32_t type = pick_type(request);
  check_room(type, request.requirements.size);
  VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
  info.allocationSize = request.requirements.size;
  info.memoryTypeIndex = type;
  MemoryBlock block;
  check(vk_.vkAllocateMemory(device_, &info, callbacks_, &block.memory), "vkAllocateMemory");
  block.coherent =
      capabilities_.memory.memoryTypes[type].propertyFlags & VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  if (request.use == MemoryUse::Device) return block;
  const VkResult mapped =
      vk_.vkMapMemory(device_, block.memory, 0, VK_WHOLE_SIZE, 0, &block.mapped);
  if (mapped != VK_SUCCESS) vk_.vkFreeMemory(device_, block.memory, callbacks_);
  check(mapped, "vkMapMemory");
  return block;
}

MemoryBlock MemoryAllocator::allocate(const MemoryRequest& request) {
  const std::lock_guard lock(mutex_);
  const MemoryBlock block = hooks_.allocate ? hooks_.allocate(request) : allocate_own(request);
  used_ += request.requirements.size;
  peak_ = std::max(peak_, used_);
  return block;
}

void MemoryAllocator::free(const MemoryBlock& block, VkDeviceSize size) noexcept {
  const std::lock_guard lock(mutex_);
  used_ -= size;
  if (hooks_.free)
    hooks_.free(block);
  else
    vk_.vkFreeMemory(device_, block.memory, callbacks_);
}

std::uint64_t MemoryAllocator::peak_bytes() const {
  const std::lock_guard lock(mutex_);
  return peak_;
}

}  // namespace planish::vulkan
