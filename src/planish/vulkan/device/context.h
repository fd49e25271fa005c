#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>

#include "planish/vulkan/device/binding_limit.h"
#include "planish/vulkan/device/capabilities.h"
#include "planish/vulkan/device/debug_labels.h"
#include "planish/vulkan/device/functions.h"
#include "planish/vulkan/device/memory.h"
#include "planish/vulkan/device/pipelines.h"

namespace planish::vulkan {

class OwnDevice;

/// What the host enabled on its instance and device: that cannot be asked of a VkDevice. planish
/// needs none of it.
struct EnabledFeatures {
  bool debug_utils = false;  ///< VK_EXT_debug_utils: objects get names, recorded work gets labels
};

/// What a host gives. Nothing is owned; everything must outlive the Context.
struct HostDevice {
  PFN_vkGetInstanceProcAddr get_instance_proc = nullptr;
  VkInstance instance = VK_NULL_HANDLE;
  VkPhysicalDevice physical_device = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
  /// The lower of VkApplicationInfo::apiVersion and the device's; 1.1 at least.
  std::uint32_t api_version = VK_API_VERSION_1_1;
  EnabledFeatures features;
  VkPipelineCache pipeline_cache = VK_NULL_HANDLE;
  const VkAllocationCallbacks* allocation_callbacks = nullptr;
  MemoryHooks memory;
  /// Gets what a developer may want to know, one line a call: what was chosen, how large tables
  /// are, and which record_ function did nothing for want of an option. Called where objects are
  /// made, and by that function, on the thread that does so.
  std::function<void(std::string_view)> log;
};

/// Where a CPU plays the device, storage buffers are read lane by lane but texel buffers by
/// gathers, barriers suspend every subgroup, and a work group's fixed costs weigh more.
inline constexpr PipelineVariant kSoftwareVariant{ReadPath::Texel, 16, true};
inline constexpr PipelineVariant kHardwareVariant{ReadPath::Storage, 1, false};

struct ContextOptions {
  /// Bytes that one binding may span at most, below the device's limit; 0: the device's limit.
  std::uint64_t max_storage_range = 0;
  /// Work groups of one dispatch at most, below the device's limit; 0: the device's limit.
  std::uint32_t max_group_count = 0;
  /// How kernels read and sum; unset: what suits the device.
  std::optional<PipelineVariant> variant;
  /// What else the host does with buffers that planish makes, as an osd::VkVertexBuffer whose
  /// triangles rays meet: VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR and
  /// VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT. With the latter memory has addresses, too; that of
  /// MemoryHooks is the host's to allocate so. The device has enabled what they need.
  VkBufferUsageFlags further_usage = 0;
};

/// Device functions, limits, memory and pipelines: what all objects on a device share. Never
/// submits, never waits. Thread-safe; outlives every object made with it.
class Context {
 public:
  /// Throws Error{NoDevice} where the device is not usable, saying why.
  explicit Context(const HostDevice& host, const ContextOptions& options = {});
  /// On the command's own device, which outlives the Context.
  explicit Context(const OwnDevice& own, const ContextOptions& options = {});

  [[nodiscard]] const DeviceFunctions& vk() const { return functions_; }
  [[nodiscard]] VkDevice device() const { return device_; }
  [[nodiscard]] const VkAllocationCallbacks* callbacks() const { return callbacks_; }
  [[nodiscard]] const Capabilities& capabilities() const { return capabilities_; }
  [[nodiscard]] MemoryAllocator& memory() { return memory_; }
  [[nodiscard]] const Pipelines& pipelines() const { return pipelines_; }

  /// Of maxStorageBufferRange, maxMemoryAllocationSize and, where kernels read texel buffers,
  /// maxTexelBufferElements of four bytes, the smallest that they have.
  [[nodiscard]] const BindingLimit& binding_limit() const { return binding_limit_; }
  [[nodiscard]] std::uint64_t max_storage_range() const { return binding_limit_.bytes; }
  [[nodiscard]] std::uint32_t max_group_count() const { return max_group_count_; }
  /// Work groups of a dispatch in x and z: in z more than one where x may not be as many, so that
  /// some may be too many. Kernels take them by item_of_lane().
  struct Groups {
    std::uint32_t x, z;
  };
  [[nodiscard]] Groups groups_in_layers(std::uint32_t groups) const {
    const std::uint32_t layers = groups / max_group_count_ + (groups % max_group_count_ ? 1 : 0);
    return layers <= 1 ? Groups{groups, 1} : Groups{max_group_count_, layers};
  }
  /// Work groups of a dispatch whose lanes go on with further items after their own: as many as
  /// `count` items need, or may be.
  [[nodiscard]] std::uint32_t groups_of(std::uint64_t count, std::uint32_t lanes = 64) const {
    return static_cast<std::uint32_t>(
        std::min<std::uint64_t>((count + lanes - 1) / lanes, max_group_count_));
  }
  [[nodiscard]] const PipelineVariant& variant() const { return variant_; }
  [[nodiscard]] VkBufferUsageFlags further_usage() const { return further_usage_; }

  [[nodiscard]] const DebugLabels& labels() const { return labels_; }
  void log(std::string_view line) const {
    if (log_) log_(line);
  }
  /// The same while recording, which cannot fail: what the host throws is dropped.
  void tell(std::string_view line) const noexcept;

 private:
  VkDevice device_;
  const VkAllocationCallbacks* callbacks_;
  Capabilities capabilities_;
  PipelineVariant variant_;
  BindingLimit binding_limit_;
  std::uint32_t max_group_count_;
  VkBufferUsageFlags further_usage_;
  std::function<void(std::string_view)> log_;
  DeviceFunctions functions_;
  DebugLabels labels_;
  MemoryAllocator memory_;
  Pipelines pipelines_;
};

}  // namespace planish::vulkan
