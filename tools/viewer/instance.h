#pragma once

#include <vulkan/vulkan.h>

#include <functional>
#include <string_view>
#include <vector>

namespace planish::viewer {

struct InstanceOptions {
  /// Turns on VK_LAYER_KHRONOS_validation with synchronization validation.
  bool validation = false;
  std::function<void(std::string_view)> message;  ///< gets every message of the layer
  std::vector<const char*> extensions;            ///< that a window needs
};

/// The application's Vulkan 1.1 instance.
class Instance {
 public:
  /// Throws Error{NoDevice}.
  explicit Instance(const InstanceOptions& options);
  ~Instance();
  Instance(const Instance&) = delete;
  Instance& operator=(const Instance&) = delete;

  [[nodiscard]] VkInstance handle() const { return instance_; }
  /// Whether VK_EXT_debug_utils is enabled, which validation does.
  [[nodiscard]] bool has_debug_utils() const { return messenger_ != VK_NULL_HANDLE; }

 private:
  std::function<void(std::string_view)> message_;
  VkInstance instance_ = VK_NULL_HANDLE;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
};

}  // namespace planish::viewer
