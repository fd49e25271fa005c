#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "planish/vulkan/device/debug_labels.h"
#include "planish/vulkan/device/functions.h"

namespace planish::vulkan {

/// What kernels.h names.
enum class Kernel : std::uint32_t;

/// What a binding holds. All but Storage are read only, and are uniform texel buffers where the
/// device reads those faster.
enum class Binding { Storage, Entries, Words, Records, Points, Pairs, Floats };

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

/// Specialisation constants below this one follow from the variant.
inline constexpr std::uint32_t kFirstOwnConstant = 3;

/// The compute pipelines of all kernels on one device, each compiled when it is first wanted.
class Pipelines {
 public:
  /// Makes the layouts. Throws planish::Error.
  Pipelines(const DeviceFunctions& functions, VkDevice device, VkPipelineCache cache,
            const VkAllocationCallbacks* callbacks, const PipelineVariant& variant,
            const DebugLabels& labels);
  ~Pipelines();
  Pipelines(const Pipelines&) = delete;
  Pipelines& operator=(const Pipelines&) = delete;

  /// With a VkPipeline once it was prepared.
  [[nodiscard]] const Pipeline& operator[](Kernel kernel) const {
    return pipelines_[static_cast<std::size_t>(kernel)];
  }

  /// Compiles the kernel, which is not only specialised, unless that was done. Thread-safe. Throws
  /// planish::Error.
  void prepare(Kernel kernel) const;

  /// The kernel with its own specialisation constants, those with ids from kFirstOwnConstant on,
  /// instead of their defaults. Compiled when first asked for; as long-lived as this. Thread-safe.
  /// Throws planish::Error.
  [[nodiscard]] Pipeline specialised(Kernel kernel, std::span<const std::uint32_t> constants) const;

 private:
  void create(Kernel kernel);
  [[nodiscard]] VkPipeline compile(Kernel kernel, VkPipelineLayout layout,
                                   std::span<const std::uint32_t> constants) const;
  void destroy() noexcept;

  const DeviceFunctions& vk_;
  VkDevice device_;
  VkPipelineCache cache_;
  const VkAllocationCallbacks* callbacks_;
  PipelineVariant variant_;
  const DebugLabels& labels_;
  mutable std::vector<Pipeline> pipelines_;
  mutable std::mutex mutex_;  // of what is compiled
  mutable std::map<std::pair<Kernel, std::vector<std::uint32_t>>, VkPipeline> specialised_;
};

}  // namespace planish::vulkan
