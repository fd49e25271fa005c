#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "device.h"
#include "scene.h"

struct GLFWwindow;

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

struct WindowOptions {
  int width = 1280, height = 720;
  std::string device;  ///< as in DeviceOptions
  bool validation = false;
  std::function<void(std::string_view)> message;  ///< of the validation layer
  OrbitCamera camera;
  ViewSettings settings;
  bool edits = false;  ///< begins at rest, with points to drag
  std::string save;    ///< prefix of what is saved; empty: the scene's name and "_edited"
  int frames = 0;      ///< closes after so many; 0: when the user does
  /// Called before each frame with its number: where tests act as the user.
  std::function<void(GLFWwindow*, int)> before_frame;
};

/// What a window showed.
struct WindowRun {
  int frames = 0;
  double seconds = 0;
};

/// Shows the animation in a window until it is closed. Throws Error{NoDevice} where there is no
/// display, and what Device and Renderer throw.
WindowRun run_window(Scene scene, const WindowOptions& options);

}  // namespace planish::viewer
