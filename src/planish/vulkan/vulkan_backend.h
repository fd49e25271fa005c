#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "planish/solve/backend.h"

namespace planish {

/// A physical device that a Vulkan driver offers.
struct VulkanDeviceInfo {
  DeviceDescription description;  ///< kind is "gpu" or "software"
  bool usable = false;
  std::string reason;                   ///< why not; empty if usable
  std::uint64_t memory_bytes = 0;       ///< largest device-local heap
  std::uint64_t max_storage_bytes = 0;  ///< that a binding may span
  std::uint64_t max_allocation_bytes = 0;
  std::uint32_t max_work_groups = 0;      ///< of one dispatch
  std::uint32_t max_storage_buffers = 0;  ///< of one kernel
  bool portability_subset = false;        ///< a layer over another API: VK_KHR_portability_subset
  std::vector<std::string> missing;       ///< what it lacks that is not needed, and what that costs
};

/// What list_vulkan_devices found. A device's index is its place in the list.
struct VulkanDeviceList {
  std::vector<VulkanDeviceInfo> devices;
  int best = -1;       ///< index of the device that an empty VulkanBackendOptions::device takes
  std::string reason;  ///< why the list is empty: no loader or no driver; else empty
};

/// All Vulkan devices of this machine. A missing loader or driver is no error.
[[nodiscard]] VulkanDeviceList list_vulkan_devices();

/// How kernels read tables and points: storage buffers suit hardware, texel buffers suit software
/// devices, whose drivers gather from them many times faster.
enum class VulkanReads { Auto, StorageBuffers, TexelBuffers };

struct VulkanBackendOptions {
  /// An index of list_vulkan_devices(), a UUID, a name or unique part of one in any case; empty:
  /// the best usable device, hardware before software.
  std::string device;
  /// Turns the validation layer on, with synchronization validation; `validation_message` gets
  /// what it says, from any thread.
  bool validation = false;
  std::function<void(std::string_view)> validation_message;
  /// Bytes that a binding may span and work groups a dispatch may have, below the device's own
  /// limits, which 0 stands for. Larger tables are done in slices.
  std::uint64_t max_storage_bytes = 0;
  std::uint32_t max_work_groups = 0;
  VulkanReads reads = VulkanReads::Auto;
};

/// A backend on a Vulkan device that it creates for itself; computes in float. Throws
/// Error{NoDevice}, saying what is missing or which devices there are.
[[nodiscard]] std::unique_ptr<Backend> make_vulkan_backend(
    const VulkanBackendOptions& options = {});

}  // namespace planish
