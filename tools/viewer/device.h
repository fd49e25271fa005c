#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "handles.h"
#include "instance.h"
#include "planish/vulkan/embed.h"

namespace planish::viewer {

struct DeviceOptions {
  std::string wanted;  ///< a device's number or part of its name, in any case; empty: the best
  VkSurfaceKHR surface = VK_NULL_HANDLE;  ///< that it has to present to; none: off-screen
  std::vector<const char*> extensions{};  ///< further ones, which the device has to have
  const void* features = nullptr;         ///< what enables theirs, a chain of pNext
};

/// The application's device with one queue for graphics, compute and, with a surface, presenting.
class Device {
 public:
  /// Throws Error{NoDevice}, listing what there is and why it does not serve.
  Device(const Instance& instance, const DeviceOptions& options);

  operator VkDevice() const { return device_.get(); }
  [[nodiscard]] VkInstance instance() const { return instance_; }
  [[nodiscard]] VkPhysicalDevice physical() const { return physical_; }
  [[nodiscard]] VkQueue queue() const { return queue_; }
  [[nodiscard]] std::uint32_t family() const { return family_; }
  [[nodiscard]] const std::string& name() const { return name_; }
  /// Whether a CPU plays the device.
  [[nodiscard]] bool is_software() const { return is_software_; }
  /// Throws Error{NoDevice} where it has none.
  void demand_tessellation() const;
  [[nodiscard]] bool has_tessellation() const { return has_tessellation_; }
  /// What planish is given.
  [[nodiscard]] vulkan::HostDevice host() const;

  /// First memory type among `allowed` with all of `wanted`. Throws Error{OutOfMemory}.
  [[nodiscard]] std::uint32_t memory_type(std::uint32_t allowed,
                                          VkMemoryPropertyFlags wanted) const;
  /// Records, submits and waits: for setting up and reading back, not for frames.
  void run(const std::function<void(VkCommandBuffer)>& record) const;
  void wait_idle() const;

 private:
  struct Destroy {
    void operator()(VkDevice device) const { vkDestroyDevice(device, nullptr); }
  };
  VkInstance instance_;
  bool has_debug_utils_;
  VkPhysicalDevice physical_ = VK_NULL_HANDLE;
  std::string name_;
  bool is_software_ = false, has_tessellation_ = false;
  std::uint32_t family_ = 0;
  std::unique_ptr<std::remove_pointer_t<VkDevice>, Destroy> device_;
  VkQueue queue_ = VK_NULL_HANDLE;
  VkPhysicalDeviceMemoryProperties memory_{};
};

}  // namespace planish::viewer
