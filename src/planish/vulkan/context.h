#pragma once

#include <cstdint>
#include <optional>

#include "planish/vulkan/capabilities.h"
#include "planish/vulkan/functions.h"
#include "planish/vulkan/memory.h"
#include "planish/vulkan/pipelines.h"

namespace planish::vulkan {

/// What a host gives. Nothing is owned; everything must outlive the Context.
struct HostDevice {
  PFN_vkGetInstanceProcAddr get_instance_proc = nullptr;
  VkInstance instance = VK_NULL_HANDLE;
  VkPhysicalDevice physical_device = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
  VkPipelineCache pipeline_cache = VK_NULL_HANDLE;
  const VkAllocationCallbacks* allocation_callbacks = nullptr;
  MemoryHooks memory;
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
};

/// Device functions, limits, memory and pipelines: what all objects on a device share. Never
/// submits, never waits. Thread-safe; outlives every object made with it.
class Context {
 public:
  /// Throws Error{NoDevice} where the device is not usable, saying why.
  explicit Context(const HostDevice& host, const ContextOptions& options = {});

  [[nodiscard]] const DeviceFunctions& vk() const { return functions_; }
  [[nodiscard]] VkDevice device() const { return device_; }
  [[nodiscard]] const VkAllocationCallbacks* callbacks() const { return callbacks_; }
  [[nodiscard]] const Capabilities& capabilities() const { return capabilities_; }
  [[nodiscard]] MemoryAllocator& memory() { return memory_; }
  [[nodiscard]] const Pipelines& pipelines() const { return pipelines_; }

  [[nodiscard]] std::uint64_t max_storage_range() const { return max_storage_range_; }
  [[nodiscard]] std::uint32_t max_group_count() const { return max_group_count_; }
  /// Elements that a texel buffer may have; no limit where kernels read storage buffers.
  [[nodiscard]] std::uint64_t max_texel_elements() const;
  [[nodiscard]] const PipelineVariant& variant() const { return variant_; }

 private:
  VkDevice device_;
  const VkAllocationCallbacks* callbacks_;
  Capabilities capabilities_;
  std::uint64_t max_storage_range_;
  std::uint32_t max_group_count_;
  PipelineVariant variant_;
  DeviceFunctions functions_;
  MemoryAllocator memory_;
  Pipelines pipelines_;
};

}  // namespace planish::vulkan
