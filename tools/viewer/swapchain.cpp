#include "swapchain.h"

#include <algorithm>

#include "planish/core/error.h"

namespace planish::viewer {
namespace {

constexpr std::uint32_t kUndefinedExtent = 0xffffffff;  // the surface takes the swapchain's

VkSurfaceFormatKHR pick_format(const Device& device, VkSurfaceKHR surface) {
  std::uint32_t count = 0;
  vulkan::check(vkGetPhysicalDeviceSurfaceFormatsKHR(device.physical(), surface, &count, nullptr),
                "vkGetPhysicalDeviceSurfaceFormatsKHR");
  std::vector<VkSurfaceFormatKHR> formats(count);
  vulkan::check(
      vkGetPhysicalDeviceSurfaceFormatsKHR(device.physical(), surface, &count, formats.data()),
      "vkGetPhysicalDeviceSurfaceFormatsKHR");
  for (const VkFormat wanted : {VK_FORMAT_B8G8R8A8_UNORM, VK_FORMAT_R8G8B8A8_UNORM})
    for (const VkSurfaceFormatKHR& format : formats)
      if (format.format == wanted) return format;
  throw Error(ErrorCode::NoDevice, device.name() + " shows no 8-bit format in this window");
}

/// The display's pace; but a software device is slower than any display, and virtual displays, on
/// which it mostly runs, have a pace of one frame a second.
VkPresentModeKHR present_mode(const Device& device, VkSurfaceKHR surface) {
  if (!device.is_software()) return VK_PRESENT_MODE_FIFO_KHR;
  std::uint32_t count = 0;
  vulkan::check(
      vkGetPhysicalDeviceSurfacePresentModesKHR(device.physical(), surface, &count, nullptr),
      "vkGetPhysicalDeviceSurfacePresentModesKHR");
  std::vector<VkPresentModeKHR> modes(count);
  vulkan::check(
      vkGetPhysicalDeviceSurfacePresentModesKHR(device.physical(), surface, &count, modes.data()),
      "vkGetPhysicalDeviceSurfacePresentModesKHR");
  const bool immediate = std::ranges::find(modes, VK_PRESENT_MODE_IMMEDIATE_KHR) != modes.end();
  return immediate ? VK_PRESENT_MODE_IMMEDIATE_KHR : VK_PRESENT_MODE_FIFO_KHR;
}

}  // namespace

std::optional<VkExtent2D> swapchain_extent(const VkSurfaceCapabilitiesKHR& surface,
                                           VkExtent2D framebuffer) {
  VkExtent2D extent = surface.currentExtent;
  if (extent.width == kUndefinedExtent) {
    if (framebuffer.width == 0 || framebuffer.height == 0) return std::nullopt;
    extent.width =
        std::clamp(framebuffer.width, surface.minImageExtent.width, surface.maxImageExtent.width);
    extent.height = std::clamp(framebuffer.height, surface.minImageExtent.height,
                               surface.maxImageExtent.height);
  }
  if (extent.width == 0 || extent.height == 0) return std::nullopt;
  return extent;
}

VkFormat surface_format(const Device& device, VkSurfaceKHR surface) {
  return pick_format(device, surface).format;
}

Swapchain::Swapchain(const Device& device, VkSurfaceKHR surface, VkRenderPass pass)
    : device_(device), surface_(surface), pass_(pass) {
  const VkSurfaceFormatKHR format = pick_format(device, surface);
  format_ = format.format;
  colour_space_ = format.colorSpace;
}

void Swapchain::resize(VkExtent2D framebuffer) {
  device_.wait_idle();
  targets_.reset();
  views_.clear();
  drawn_.clear();
  VkSurfaceCapabilitiesKHR surface;
  vulkan::check(vkGetPhysicalDeviceSurfaceCapabilitiesKHR(device_.physical(), surface_, &surface),
                "vkGetPhysicalDeviceSurfaceCapabilitiesKHR");
  const auto extent = swapchain_extent(surface, framebuffer);
  if (!extent) return;
  VkSwapchainCreateInfoKHR info{VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR};
  info.surface = surface_;
  // One more than the least, so that drawing need not wait for the display.
  info.minImageCount = surface.minImageCount + 1;
  if (surface.maxImageCount > 0)
    info.minImageCount = std::min(info.minImageCount, surface.maxImageCount);
  info.imageFormat = format_;
  info.imageColorSpace = colour_space_;
  info.imageExtent = *extent;
  info.imageArrayLayers = 1;
  info.imageUsage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
  info.preTransform = surface.currentTransform;
  info.compositeAlpha = VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR;
  info.presentMode = present_mode(device_, surface_);
  info.clipped = VK_TRUE;
  info.oldSwapchain = swapchain_;
  swapchain_ = OwnedSwapchain(device_, info, "vkCreateSwapchainKHR");

  std::uint32_t count = 0;
  vulkan::check(vkGetSwapchainImagesKHR(device_, swapchain_, &count, nullptr),
                "vkGetSwapchainImagesKHR");
  std::vector<VkImage> images(count);
  vulkan::check(vkGetSwapchainImagesKHR(device_, swapchain_, &count, images.data()),
                "vkGetSwapchainImagesKHR");
  const VkSemaphoreCreateInfo semaphore{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
  for (const VkImage image : images) {
    views_.push_back(make_view(device_, image, format_, VK_IMAGE_ASPECT_COLOR_BIT));
    drawn_.emplace_back(device_, semaphore, "vkCreateSemaphore");
  }
  const std::vector<VkImageView> views(views_.begin(), views_.end());
  targets_.emplace(device_, pass_, format_, *extent, views);
}

std::optional<std::uint32_t> Swapchain::acquire(VkSemaphore ready) {
  std::uint32_t image = 0;
  const VkResult result =
      vkAcquireNextImageKHR(device_, swapchain_, UINT64_MAX, ready, VK_NULL_HANDLE, &image);
  if (result == VK_ERROR_OUT_OF_DATE_KHR) return std::nullopt;
  // A suboptimal image is there and has to be presented; present() tells then.
  if (result != VK_SUBOPTIMAL_KHR) vulkan::check(result, "vkAcquireNextImageKHR");
  return image;
}

bool Swapchain::present(std::uint32_t image) {
  VkPresentInfoKHR info{VK_STRUCTURE_TYPE_PRESENT_INFO_KHR};
  info.waitSemaphoreCount = 1;
  info.pWaitSemaphores = drawn_[image].address();
  info.swapchainCount = 1;
  info.pSwapchains = swapchain_.address();
  info.pImageIndices = &image;
  const VkResult result = vkQueuePresentKHR(device_.queue(), &info);
  if (result == VK_ERROR_OUT_OF_DATE_KHR || result == VK_SUBOPTIMAL_KHR) return false;
  vulkan::check(result, "vkQueuePresentKHR");
  return true;
}

}  // namespace planish::viewer
