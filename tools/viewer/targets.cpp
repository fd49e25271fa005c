#include "targets.h"

#include <array>

#include "planish/core/error.h"

namespace planish::viewer {
namespace {

VkFormat depth_format(const Device& device) {
  // Vulkan promises one of them.
  for (const VkFormat format : {VK_FORMAT_D32_SFLOAT, VK_FORMAT_X8_D24_UNORM_PACK32}) {
    VkFormatProperties properties;
    vkGetPhysicalDeviceFormatProperties(device.physical(), format, &properties);
    if (properties.optimalTilingFeatures & VK_FORMAT_FEATURE_DEPTH_STENCIL_ATTACHMENT_BIT)
      return format;
  }
  throw Error(ErrorCode::NoDevice, device.name() + " has no depth format");
}

VkAttachmentDescription attachment(VkFormat format, VkSampleCountFlagBits samples) {
  VkAttachmentDescription description{};
  description.format = format;
  description.samples = samples;
  description.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
  description.storeOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
  description.stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
  description.stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
  description.initialLayout = VK_IMAGE_LAYOUT_UNDEFINED;
  return description;
}

constexpr VkPipelineStageFlags kDrawStages = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT |
                                             VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT |
                                             VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT;
constexpr VkAccessFlags kDrawWrites =
    VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
constexpr VkAccessFlags kDrawAccesses =
    kDrawWrites | VK_ACCESS_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT;

/// Frames share colour and depth: a frame's draws wait for those of the last one, and for the
/// swapchain's semaphore, whose wait stage is colour output. Copies wait for draws.
std::array<VkSubpassDependency, 2> dependencies() {
  VkSubpassDependency before{VK_SUBPASS_EXTERNAL, 0,           kDrawStages,
                             kDrawStages,         kDrawWrites, kDrawAccesses};
  VkSubpassDependency after{0,
                            VK_SUBPASS_EXTERNAL,
                            VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT,
                            VK_PIPELINE_STAGE_TRANSFER_BIT,
                            VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT,
                            VK_ACCESS_TRANSFER_READ_BIT};
  return {before, after};
}

}  // namespace

OwnedRenderPass make_render_pass(const Device& device, const RenderPassOptions& options) {
  std::array attachments{attachment(options.colour, kSamples),
                         attachment(depth_format(device), kSamples),
                         attachment(options.colour, VK_SAMPLE_COUNT_1_BIT)};
  attachments[0].finalLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
  attachments[1].finalLayout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
  attachments[2].loadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
  attachments[2].storeOp = VK_ATTACHMENT_STORE_OP_STORE;
  attachments[2].finalLayout = options.final_layout;
  const VkAttachmentReference colour{0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
  const VkAttachmentReference depth{1, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL};
  const VkAttachmentReference resolved{2, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
  VkSubpassDescription subpass{};
  subpass.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS;
  subpass.colorAttachmentCount = 1;
  subpass.pColorAttachments = &colour;
  subpass.pResolveAttachments = &resolved;
  subpass.pDepthStencilAttachment = &depth;
  const auto outside = dependencies();
  VkRenderPassCreateInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO};
  info.attachmentCount = attachments.size();
  info.pAttachments = attachments.data();
  info.subpassCount = 1;
  info.pSubpasses = &subpass;
  info.dependencyCount = outside.size();
  info.pDependencies = outside.data();
  return OwnedRenderPass(device, info, "vkCreateRenderPass");
}

Targets::Targets(const Device& device, VkRenderPass pass, VkFormat colour, VkExtent2D extent,
                 std::span<const VkImageView> resolved)
    : pass_(pass),
      extent_(extent),
      colour_(device,
              {colour, extent, kSamples,
               VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSIENT_ATTACHMENT_BIT,
               VK_IMAGE_ASPECT_COLOR_BIT}),
      depth_(device,
             {depth_format(device), extent, kSamples,
              VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSIENT_ATTACHMENT_BIT,
              VK_IMAGE_ASPECT_DEPTH_BIT}) {
  for (const VkImageView view : resolved) {
    const std::array views{colour_.view(), depth_.view(), view};
    VkFramebufferCreateInfo info{VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO};
    info.renderPass = pass;
    info.attachmentCount = views.size();
    info.pAttachments = views.data();
    info.width = extent.width;
    info.height = extent.height;
    info.layers = 1;
    framebuffers_.emplace_back(device, info, "vkCreateFramebuffer");
  }
}

void Targets::begin(VkCommandBuffer commands, std::size_t image) const {
  std::array<VkClearValue, 2> clear{};
  clear[1].depthStencil.depth = 1;
  VkRenderPassBeginInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
  info.renderPass = pass_;
  info.framebuffer = framebuffers_[image];
  info.renderArea.extent = extent_;
  info.clearValueCount = clear.size();
  info.pClearValues = clear.data();
  vkCmdBeginRenderPass(commands, &info, VK_SUBPASS_CONTENTS_INLINE);
  const VkViewport viewport{
      0, 0, static_cast<float>(extent_.width), static_cast<float>(extent_.height), 0, 1};
  const VkRect2D scissor{{0, 0}, extent_};
  vkCmdSetViewport(commands, 0, 1, &viewport);
  vkCmdSetScissor(commands, 0, 1, &scissor);
}

}  // namespace planish::viewer
