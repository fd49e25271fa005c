#pragma once

#define VK_NO_PROTOTYPES
#include <vulkan/vulkan_core.h>

#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

/// A buffer in memory that the application maps.
struct MappedBuffer {
  VkBuffer handle = VK_NULL_HANDLE;
  VkDeviceMemory memory = VK_NULL_HANDLE;
  std::span<std::byte> bytes;
};

/// A small application that owns its VkInstance, VkDevice, queue and memory, and whose loader is
/// its own: libvulkan.so.1 through dlopen.
class Application {
 public:
  Application();
  ~Application();
  Application(const Application&) = delete;
  Application& operator=(const Application&) = delete;

  PFN_vkGetInstanceProcAddr get_instance_proc = nullptr;
  VkInstance instance = VK_NULL_HANDLE;
  VkPhysicalDevice physical_device = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
  VkQueue queue = VK_NULL_HANDLE;  // of graphics and compute
  std::uint32_t family = 0;
  bool has_tessellation = false;  ///< then it is enabled
  bool is_software = false;       ///< a CPU plays the device

  template <class Function>
  [[nodiscard]] Function load(const char* name) const {
    const auto function = reinterpret_cast<Function>(get_instance_proc(instance, name));
    if (!function) throw std::runtime_error(name);
    return function;
  }
  /// The first type of memory of these that has all properties. Throws where there is none.
  [[nodiscard]] std::uint32_t memory_type(std::uint32_t types, VkMemoryPropertyFlags wanted) const;
  MappedBuffer make_buffer(VkDeviceSize size, VkBufferUsageFlags usage);
  /// Records, submits and waits.
  void run(const std::function<void(VkCommandBuffer)>& record);
  /// Makes what compute shaders wrote readable as vertices, and by the host.
  void vertices_after(VkCommandBuffer commands, VkPipelineStageFlags stages,
                      VkAccessFlags accesses);
  /// What the validation layer said, where it is installed.
  std::vector<std::string> messages;

 private:
  void make_instance();
  void make_device();

  void* library_ = nullptr;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
  VkCommandPool pool_ = VK_NULL_HANDLE;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
  std::list<MappedBuffer> buffers_;
};

/// A function of the instance, by its name.
#define LOAD(app, name) (app).load<PFN_##name>(#name)
/// Throws where a call failed.
void check(VkResult result, const char* call);
