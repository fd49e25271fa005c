#pragma once

#include <array>
#include <functional>
#include <initializer_list>
#include <span>
#include <vector>

#include "application.h"

/// Where a vertex attribute is: the binding of its buffer, and bytes from a vertex's beginning.
struct Attribute {
  std::uint32_t binding;
  VkFormat format;
  std::uint32_t offset;
};

/// SPIR-V of a pass's stages. Without a fragment stage depth alone is written; with those of
/// tessellation patches of one vertex are drawn instead of triangles, front faces only.
struct Stages {
  std::span<const std::uint32_t> vertex, fragment, control, evaluation;
};

/// Images that a pass draws, and what is drawn into them: one pipeline.
struct Pass {
  VkRenderPass pass = VK_NULL_HANDLE;
  VkFramebuffer framebuffer = VK_NULL_HANDLE;
  VkPipelineLayout layout = VK_NULL_HANDLE;
  VkPipeline pipeline = VK_NULL_HANDLE;
  VkDescriptorSet set = VK_NULL_HANDLE;
  VkShaderStageFlags parameter_stages = 0;
  std::vector<VkImage> images;  ///< as attached, depth last
  std::vector<VkFormat> formats;
};

/// A compute pipeline over storage buffers, with a set for each list of them.
struct Kernel {
  VkPipelineLayout layout = VK_NULL_HANDLE;
  VkPipeline pipeline = VK_NULL_HANDLE;
  std::vector<VkDescriptorSet> sets;
};

/// The Vulkan objects of a small renderer; destroyed with it, when the device is idle.
class FrameObjects {
 public:
  explicit FrameObjects(Application& app) : app_(app) {}
  ~FrameObjects();
  FrameObjects(const FrameObjects&) = delete;
  FrameObjects& operator=(const FrameObjects&) = delete;

  /// Colours of these formats and depth, `side` pixels square; afterwards they can be copied.
  /// `strides`: of each vertex buffer; `buffers`: what the stages read at bindings 0, 1, ...
  Pass make_pass(std::uint32_t side, std::initializer_list<VkFormat> colours, const Stages& stages,
                 std::initializer_list<std::uint32_t> strides,
                 std::initializer_list<Attribute> attributes, std::uint32_t parameter_bytes,
                 const std::vector<VkDescriptorBufferInfo>& buffers = {});
  Kernel make_kernel(std::span<const std::uint32_t> code, std::uint32_t parameter_bytes,
                     const std::vector<std::vector<VkBuffer>>& sets);
  VkCommandBuffer make_commands();
  VkFence make_fence();

 private:
  VkImageView make_image(std::uint32_t side, VkFormat format, VkImageUsageFlags usage,
                         VkImageAspectFlags aspect, VkImage& image);
  VkRenderPass make_render_pass(const Pass& pass);
  VkShaderModule make_module(std::span<const std::uint32_t> code);
  VkDescriptorSetLayout make_sets(VkShaderStageFlags stages,
                                  const std::vector<std::vector<VkDescriptorBufferInfo>>& buffers,
                                  std::vector<VkDescriptorSet>& sets);
  VkPipelineLayout make_layout(VkShaderStageFlags stages, std::uint32_t parameter_bytes,
                               VkDescriptorSetLayout sets);
  template <class Handle, class Destroy>
  Handle keep(Handle handle, Destroy destroy) {
    destroy_.push_back([=, this] { destroy(app_.device, handle, nullptr); });
    return handle;
  }

  Application& app_;
  VkCommandPool pool_ = VK_NULL_HANDLE;
  std::vector<std::function<void()>> destroy_;
};
