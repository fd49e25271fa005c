#pragma once

#include <optional>
#include <vector>

#include "targets.h"

namespace planish::viewer {

/// The extent of a swapchain for a framebuffer of that size; empty where nothing can be shown, as
/// in a minimised window.
[[nodiscard]] std::optional<VkExtent2D> swapchain_extent(const VkSurfaceCapabilitiesKHR& surface,
                                                         VkExtent2D framebuffer);

/// An 8-bit format whose values are shown as they are written, since the shaders encode sRGB
/// themselves. Throws Error{NoDevice}.
[[nodiscard]] VkFormat surface_format(const Device& device, VkSurfaceKHR surface);

/// The images of a window, drawn to in the render pass that it is made for.
class Swapchain {
 public:
  /// `pass` is of make_render_pass() for surface_format() and presenting.
  Swapchain(const Device& device, VkSurfaceKHR surface, VkRenderPass pass);

  /// Makes the images anew for a framebuffer of that size, once all frames are done; without images
  /// where nothing can be shown. Throws vulkan::VulkanError.
  void resize(VkExtent2D framebuffer);
  [[nodiscard]] bool has_images() const { return targets_.has_value(); }
  [[nodiscard]] const Targets& targets() const { return *targets_; }

  /// The next image to draw to; `ready` is signalled when that may begin. Empty when the images no
  /// longer fit the window.
  [[nodiscard]] std::optional<std::uint32_t> acquire(VkSemaphore ready);
  /// Signalled when the image is drawn; one for each image, since presenting keeps it.
  [[nodiscard]] VkSemaphore drawn(std::uint32_t image) const { return drawn_[image]; }
  /// False when the images no longer fit the window.
  [[nodiscard]] bool present(std::uint32_t image);

 private:
  const Device& device_;
  VkSurfaceKHR surface_;
  VkRenderPass pass_;
  VkFormat format_;
  VkColorSpaceKHR colour_space_;
  OwnedSwapchain swapchain_;
  std::vector<OwnedImageView> views_;
  std::vector<OwnedSemaphore> drawn_;
  std::optional<Targets> targets_;
};

}  // namespace planish::viewer
