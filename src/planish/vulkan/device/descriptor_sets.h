#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "planish/vulkan/device/context.h"
#include "planish/vulkan/device/kernels.h"

namespace planish::vulkan {

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

}  // namespace planish::vulkan
