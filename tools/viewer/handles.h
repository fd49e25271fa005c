#pragma once

// With prototypes, which planish's headers would leave out.
#include <vulkan/vulkan.h>

#include <utility>

#include "planish/vulkan/device/result.h"

namespace planish::viewer {

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

}  // namespace planish::viewer
