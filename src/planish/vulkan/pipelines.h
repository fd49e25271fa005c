#pragma once

#include <array>
#include <cstdint>

#include "planish/vulkan/functions.h"

namespace planish::vulkan {

/// Every kernel, each one a file of that name in shaders/.
enum class Kernel {
  InterpolationStep,
  ReduceRms,
  FinishSolve,
  ApplyStencils,
  ApplyLimit,
  CgApply,
  CgAdvance,
  CgTurn,
  ReduceSums,
};
inline constexpr std::size_t kKernelCount = 9;

/// Storage buffers of the kernel with the most of them.
inline constexpr std::uint32_t kMaxBindings = 8;

struct Pipeline {
  VkPipeline pipeline = VK_NULL_HANDLE;
  VkPipelineLayout layout = VK_NULL_HANDLE;
  VkDescriptorSetLayout set_layout = VK_NULL_HANDLE;
  std::uint32_t binding_count = 0;
  std::uint32_t parameter_bytes = 0;  ///< size of its push constants
};

/// The compute pipelines of all kernels on one device.
class Pipelines {
 public:
  /// `chunks_per_group`: chunks of kChunkRows rows that a work group of a table kernel walks.
  Pipelines(const DeviceFunctions& functions, VkDevice device, VkPipelineCache cache,
            const VkAllocationCallbacks* callbacks, std::uint32_t chunks_per_group);
  ~Pipelines();
  Pipelines(const Pipelines&) = delete;
  Pipelines& operator=(const Pipelines&) = delete;

  [[nodiscard]] const Pipeline& operator[](Kernel kernel) const {
    return pipelines_[static_cast<std::size_t>(kernel)];
  }

 private:
  void create(Kernel kernel, VkPipelineCache cache, std::uint32_t chunks_per_group);
  void destroy() noexcept;

  const DeviceFunctions& vk_;
  VkDevice device_;
  const VkAllocationCallbacks* callbacks_;
  std::array<Pipeline, kKernelCount> pipelines_{};
};

}  // namespace planish::vulkan
