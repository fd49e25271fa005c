#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "planish/vulkan/device/context.h"
#include "planish/vulkan/device/driver.h"

namespace planish::vulkan {

struct InstanceOptions {
  /// Turns on VK_LAYER_KHRONOS_validation with synchronization validation.
  bool validation = false;
  /// Gets every message of the validation layer; may be called from any thread.
  std::function<void(std::string_view)> message;
  /// Where functions come from; unset: libvulkan.so.1, opened at run time.
  PFN_vkGetInstanceProcAddr get_proc = nullptr;
};

/// What makes a debug messenger hand the layer's warnings and errors of validation and performance
/// to `message`, which must outlive it.
[[nodiscard]] VkDebugUtilsMessengerCreateInfoEXT messenger_info(
    const std::function<void(std::string_view)>& message);

/// The command's own way to Vulkan: libvulkan.so.1, and an instance of it.
class Instance {
 public:
  /// Throws Error{NoDevice} where the loader, a driver, or the validation layer asked for is
  /// missing.
  explicit Instance(const InstanceOptions& options);
  ~Instance();
  Instance(const Instance&) = delete;
  Instance& operator=(const Instance&) = delete;

  [[nodiscard]] VkInstance handle() const { return instance_; }
  [[nodiscard]] PFN_vkGetInstanceProcAddr get_proc() const { return get_proc_; }
  [[nodiscard]] const InstanceFunctions& functions() const { return functions_; }
  /// Whether VK_EXT_debug_utils is enabled: with validation.
  [[nodiscard]] bool has_debug_utils() const { return messenger_ != VK_NULL_HANDLE; }

 private:
  void open_loader();
  void create(const InstanceOptions& options);
  void create_messenger(const VkDebugUtilsMessengerCreateInfoEXT& info);
  void destroy() noexcept;

  std::unique_ptr<void, void (*)(void*)> library_;
  PFN_vkGetInstanceProcAddr get_proc_ = nullptr;
  VkInstance instance_ = VK_NULL_HANDLE;
  InstanceFunctions functions_;
  std::function<void(std::string_view)> message_;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
};

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
