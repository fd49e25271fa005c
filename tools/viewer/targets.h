#pragma once

#include <span>
#include <vector>

#include "resources.h"

namespace planish::viewer {

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

}  // namespace planish::viewer
