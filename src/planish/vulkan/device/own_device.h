#pragma once

#include <memory>
#include <string>
#include <vector>

#include "planish/vulkan/device/capabilities.h"
#include "planish/vulkan/device/context.h"
#include "planish/vulkan/device/instance.h"

namespace planish::vulkan {

/// A physical device of an instance.
struct FoundDevice {
  VkPhysicalDevice handle = VK_NULL_HANDLE;
  Capabilities capabilities;
};

/// All physical devices, in the driver's order, usable or not.
[[nodiscard]] std::vector<FoundDevice> find_devices(const Instance& instance);

/// Index of the device that `wanted` names: "" for the best usable one (discrete before integrated
/// before virtual before software), an index, a UUID, or a name or unique part of a name in any
/// case. Throws Error{NoDevice}, listing what there is, or saying why the named one is unusable.
[[nodiscard]] std::size_t pick_device(const std::vector<FoundDevice>& devices,
                                      const std::string& wanted);

struct OwnDeviceOptions {
  std::string wanted;  ///< as in pick_device
  InstanceOptions instance;
};

/// A device that planish makes for itself, where no host gives one.
class OwnDevice {
 public:
  /// Throws Error{NoDevice}.
  explicit OwnDevice(const OwnDeviceOptions& options);
  ~OwnDevice();
  OwnDevice(const OwnDevice&) = delete;
  OwnDevice& operator=(const OwnDevice&) = delete;

  /// What a Context is made from.
  [[nodiscard]] HostDevice host_device() const;
  [[nodiscard]] const Capabilities& capabilities() const { return capabilities_; }
  [[nodiscard]] VkQueue queue() const { return queue_; }

 private:
  Instance instance_;
  VkPhysicalDevice physical_device_ = VK_NULL_HANDLE;
  Capabilities capabilities_;
  VkDevice device_ = VK_NULL_HANDLE;
  PFN_vkDestroyDevice destroy_device_ = nullptr;
  VkQueue queue_ = VK_NULL_HANDLE;
};

}  // namespace planish::vulkan
