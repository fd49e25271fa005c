#pragma once

#include <vulkan/vulkan.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "planish/vulkan/device/driver.h"
#include "planish/vulkan/embed.h"
#include "shared.h"

namespace planish::viewer {

// With prototypes, which planish's headers would leave out.

/// One object of a device, destroyed with it. `kCreate` and `kDestroy` are Vulkan's functions.
template <class Handle, auto kCreate, auto kDestroy>
class Owned {
 public:
  Owned() = default;
  /// `call` names kCreate in messages. Throws vulkan::VulkanError.
  template <class Info>
  Owned(VkDevice device, const Info& info, const char* call) : device_(device) {
    vulkan::check(kCreate(device, &info, nullptr, &handle_), call);
  }
  ~Owned() {
    if (handle_) kDestroy(device_, handle_, nullptr);
  }
  Owned(Owned&& other) noexcept
      : device_(other.device_), handle_(std::exchange(other.handle_, VK_NULL_HANDLE)) {}
  Owned& operator=(Owned&& other) noexcept {
    std::swap(device_, other.device_);
    std::swap(handle_, other.handle_);
    return *this;
  }

  operator Handle() const { return handle_; }
  [[nodiscard]] const Handle* address() const { return &handle_; }

 private:
  VkDevice device_ = VK_NULL_HANDLE;
  Handle handle_ = VK_NULL_HANDLE;
};

// Of one info, without a cache, so that pipelines are made as everything else is.
inline VkResult create_graphics_pipeline(VkDevice device, const VkGraphicsPipelineCreateInfo* info,
                                         const VkAllocationCallbacks* callbacks, VkPipeline* made) {
  return vkCreateGraphicsPipelines(device, VK_NULL_HANDLE, 1, info, callbacks, made);
}
inline VkResult create_compute_pipeline(VkDevice device, const VkComputePipelineCreateInfo* info,
                                        const VkAllocationCallbacks* callbacks, VkPipeline* made) {
  return vkCreateComputePipelines(device, VK_NULL_HANDLE, 1, info, callbacks, made);
}

using OwnedMemory = Owned<VkDeviceMemory, vkAllocateMemory, vkFreeMemory>;
using OwnedBuffer = Owned<VkBuffer, vkCreateBuffer, vkDestroyBuffer>;
using OwnedImage = Owned<VkImage, vkCreateImage, vkDestroyImage>;
using OwnedImageView = Owned<VkImageView, vkCreateImageView, vkDestroyImageView>;
using OwnedShader = Owned<VkShaderModule, vkCreateShaderModule, vkDestroyShaderModule>;
using OwnedSetLayout =
    Owned<VkDescriptorSetLayout, vkCreateDescriptorSetLayout, vkDestroyDescriptorSetLayout>;
using OwnedPipelineLayout =
    Owned<VkPipelineLayout, vkCreatePipelineLayout, vkDestroyPipelineLayout>;
using OwnedGraphicsPipeline = Owned<VkPipeline, create_graphics_pipeline, vkDestroyPipeline>;
using OwnedComputePipeline = Owned<VkPipeline, create_compute_pipeline, vkDestroyPipeline>;
using OwnedDescriptorPool =
    Owned<VkDescriptorPool, vkCreateDescriptorPool, vkDestroyDescriptorPool>;
using OwnedRenderPass = Owned<VkRenderPass, vkCreateRenderPass, vkDestroyRenderPass>;
using OwnedFramebuffer = Owned<VkFramebuffer, vkCreateFramebuffer, vkDestroyFramebuffer>;
using OwnedFence = Owned<VkFence, vkCreateFence, vkDestroyFence>;
using OwnedSemaphore = Owned<VkSemaphore, vkCreateSemaphore, vkDestroySemaphore>;
using OwnedCommandPool = Owned<VkCommandPool, vkCreateCommandPool, vkDestroyCommandPool>;
using OwnedSwapchain = Owned<VkSwapchainKHR, vkCreateSwapchainKHR, vkDestroySwapchainKHR>;

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

enum class Place {
  Device,  ///< for the device alone
  Host,    ///< mapped and coherent
};

/// A buffer with memory of its own: enough for an application of a dozen buffers.
class Buffer {
 public:
  Buffer() = default;
  /// Throws vulkan::VulkanError, Error{OutOfMemory}.
  Buffer(const Device& device, VkDeviceSize bytes, VkBufferUsageFlags usage, Place place);

  operator VkBuffer() const { return buffer_; }
  [[nodiscard]] VkDeviceSize bytes() const { return bytes_; }
  /// Of Place::Host.
  [[nodiscard]] std::span<std::byte> mapped() const {
    return {mapped_, static_cast<std::size_t>(bytes_)};
  }

 private:
  VkDeviceSize bytes_ = 0;
  OwnedMemory memory_;
  OwnedBuffer buffer_;
  std::byte* mapped_ = nullptr;
};

/// From one scope to another, for all memory.
void barrier(VkCommandBuffer commands, const vulkan::Scope& from, const vulkan::Scope& to);

/// After copies into mapped buffers: makes them visible to the host once its fence is there.
void host_barrier(VkCommandBuffer commands);

/// A buffer of these bytes in the device's own memory, which they have reached: to be read by
/// shaders and as vertices.
[[nodiscard]] Buffer buffer_of(const Device& device, std::span<const std::byte> bytes,
                               VkBufferUsageFlags usage);
/// A storage buffer of these words.
[[nodiscard]] Buffer word_buffer(const Device& device, std::span<const std::uint32_t> words);

struct ImageOptions {
  VkFormat format = VK_FORMAT_UNDEFINED;
  VkExtent2D extent{};
  VkSampleCountFlagBits samples = VK_SAMPLE_COUNT_1_BIT;
  VkImageUsageFlags usage = 0;
  VkImageAspectFlags aspect = VK_IMAGE_ASPECT_COLOR_BIT;
};

/// A two-dimensional image with a view and memory of its own.
class Image {
 public:
  /// Throws vulkan::VulkanError, Error{OutOfMemory}.
  Image(const Device& device, const ImageOptions& options);

  operator VkImage() const { return image_; }
  [[nodiscard]] VkImageView view() const { return view_; }

 private:
  OwnedMemory memory_;
  OwnedImage image_;
  OwnedImageView view_;
};

/// Of pictures, which all devices draw to and copy from.
inline constexpr VkFormat kPictureFormat = VK_FORMAT_R8G8B8A8_UNORM;
/// For a picture's pixels.
[[nodiscard]] Buffer picture_buffer(const Device& device, VkExtent2D extent);
/// Copies one that a render pass has left to be copied from.
void copy_picture(VkCommandBuffer commands, VkImage image, VkExtent2D extent, const Buffer& target);
/// Of such a buffer: RGB, top row first.
[[nodiscard]] std::vector<std::uint8_t> rgb_of(const Buffer& picture);

/// The view of a whole image.
[[nodiscard]] OwnedImageView make_view(VkDevice device, VkImage image, VkFormat format,
                                       VkImageAspectFlags aspect);

inline constexpr VkSampleCountFlagBits kSamples = VK_SAMPLE_COUNT_4_BIT;  // which all devices have

struct RenderPassOptions {
  VkFormat colour = VK_FORMAT_UNDEFINED;
  /// The resolved picture is left in it: for presenting or for copying.
  VkImageLayout final_layout = VK_IMAGE_LAYOUT_UNDEFINED;
};

/// One subpass: multisampled colour and depth, both cleared, resolved into a third attachment.
[[nodiscard]] OwnedRenderPass make_render_pass(const Device& device,
                                               const RenderPassOptions& options);

/// What a render pass of that kind draws into: framebuffers that share colour and depth, one for
/// each resolved image.
class Targets {
 public:
  Targets(const Device& device, VkRenderPass pass, VkFormat colour, VkExtent2D extent,
          std::span<const VkImageView> resolved);

  [[nodiscard]] VkExtent2D extent() const { return extent_; }
  void begin(VkCommandBuffer commands, std::size_t image) const;

 private:
  VkRenderPass pass_;
  VkExtent2D extent_;
  Image colour_, depth_;
  std::vector<OwnedFramebuffer> framebuffers_;
};

/// The viewer's shaders as pipelines, all with one layout: two descriptor sets of storage buffers
/// (shared.h) and shared::DrawParameters as push constants.
struct Pipelines {
  Pipelines(const Device& device, VkRenderPass pass);

  OwnedSetLayout set_layout, surface_layout;
  OwnedPipelineLayout layout;
  OwnedGraphicsPipeline background, surface, textured, edges, hidden_edges, points;
  OwnedGraphicsPipeline patches;  // where the device has tessellation
  OwnedComputePipeline vertex_error;
};

/// The shaders of a crowd, with a layout of their own: a set of two storage buffers, vertices and
/// the matrix of the frame before, and shared::DrawParameters.
struct CrowdPipelines {
  /// `motion_pass`: none, where no motions are drawn.
  CrowdPipelines(const Device& device, VkRenderPass pass, VkRenderPass motion_pass,
                 bool is_textured);

  OwnedSetLayout set_layout;
  OwnedPipelineLayout layout;
  OwnedGraphicsPipeline surface, motion;
};

/// Who sees the push constants.
[[nodiscard]] VkShaderStageFlags push_stages(const Device& device);

using Words = std::span<const std::uint32_t>;
enum class Blend {
  None,
  Over,
  Sum,
};

/// How one kind of thing is drawn.
struct Drawing {
  Words vertex, fragment;
  bool has_vertices = false;  ///< of the surface; else the vertex shader makes them
  bool tests_depth = true;
  Blend blend = Blend::None;
  Words control{}, evaluation{};  ///< of tessellation: patches of one point
  bool has_uvs = false;           ///< with has_vertices: in a buffer of their own
  /// Texture coordinates alone, and a vulkan::DrawnInstance an instance.
  bool is_crowd = false;
};
/// Of storage buffers, from binding 0 on.
[[nodiscard]] OwnedSetLayout make_set_layout(VkDevice device, std::uint32_t count,
                                             VkShaderStageFlags stages);
[[nodiscard]] VkDescriptorSet make_set(VkDevice device, VkDescriptorPool pool,
                                       VkDescriptorSetLayout layout,
                                       std::span<const VkDescriptorBufferInfo> buffers);
/// With shared::DrawParameters as push constants.
[[nodiscard]] OwnedPipelineLayout make_layout(const Device& device,
                                              std::span<const VkDescriptorSetLayout> sets);
/// Viewport and scissor are left to the command buffer.
[[nodiscard]] OwnedGraphicsPipeline make_drawing(VkDevice device, VkRenderPass pass,
                                                 VkPipelineLayout layout, const Drawing& drawing);

}  // namespace planish::viewer
