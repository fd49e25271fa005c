#pragma once

#include <array>
#include <cstdint>
#include <span>

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
  StopTest,
  GatherPoints,
  InitialResidual,
  TakeUp,
  ControlPoints,
};
inline constexpr std::size_t kKernelCount = 14;

/// Bindings of the kernel with the most of them.
inline constexpr std::uint32_t kMaxBindings = 8;

/// What a binding holds. All but Storage are read only, and are uniform texel buffers where the
/// device reads those faster.
enum class Binding { Storage, Entries, Words, Points, Pairs };

/// How kernels read the arrays that they only read.
enum class ReadPath { Storage, Texel };

/// VK_FORMAT_UNDEFINED for a storage buffer.
[[nodiscard]] VkFormat texel_format(Binding binding, ReadPath path);
[[nodiscard]] VkDescriptorType descriptor_type(Binding binding, ReadPath path);

struct Pipeline {
  VkPipeline pipeline = VK_NULL_HANDLE;
  VkPipelineLayout layout = VK_NULL_HANDLE;
  VkDescriptorSetLayout set_layout = VK_NULL_HANDLE;
  std::span<const Binding> bindings;
  std::uint32_t parameter_bytes = 0;  ///< size of its push constants
};

struct PipelineVariant {
  ReadPath read_path = ReadPath::Storage;
  std::uint32_t chunks_per_group = 1;  ///< chunks of kChunkRows rows that a table kernel walks
  bool lane_sums = false;              ///< partial sums per lane instead of per work group
};

/// The compute pipelines of all kernels on one device.
class Pipelines {
 public:
  /// Throws planish::Error.
  Pipelines(const DeviceFunctions& functions, VkDevice device, VkPipelineCache cache,
            const VkAllocationCallbacks* callbacks, const PipelineVariant& variant);
  ~Pipelines();
  Pipelines(const Pipelines&) = delete;
  Pipelines& operator=(const Pipelines&) = delete;

  [[nodiscard]] const Pipeline& operator[](Kernel kernel) const {
    return pipelines_[static_cast<std::size_t>(kernel)];
  }

 private:
  void create(Kernel kernel, VkPipelineCache cache, const PipelineVariant& variant);
  void destroy() noexcept;

  const DeviceFunctions& vk_;
  VkDevice device_;
  const VkAllocationCallbacks* callbacks_;
  std::array<Pipeline, kKernelCount> pipelines_{};
};

}  // namespace planish::vulkan
