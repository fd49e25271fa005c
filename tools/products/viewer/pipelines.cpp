#include <array>
#include <vector>

#include "background.frag.spv.h"
#include "background.vert.spv.h"
#include "crowd.vert.spv.h"
#include "device.h"
#include "edge.frag.spv.h"
#include "edge.vert.spv.h"
#include "motion.frag.spv.h"
#include "patch.tesc.spv.h"
#include "patch.tese.spv.h"
#include "patch.vert.spv.h"
#include "planish/core/error.h"
#include "point.frag.spv.h"
#include "point.vert.spv.h"
#include "surface.frag.spv.h"
#include "surface.vert.spv.h"
#include "textured.frag.spv.h"
#include "textured.vert.spv.h"
#include "vertex_error.comp.spv.h"

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

// Frames share colour and depth: a frame's draws wait for those of the last one, and for the
// swapchain's semaphore, whose wait stage is colour output. Copies wait for draws.
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

namespace {

OwnedShader make_shader(VkDevice device, Words words) {
  VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
  info.codeSize = words.size_bytes();
  info.pCode = words.data();
  return OwnedShader(device, info, "vkCreateShaderModule");
}

VkPipelineShaderStageCreateInfo stage(VkShaderStageFlagBits which, VkShaderModule shader) {
  VkPipelineShaderStageCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
  info.stage = which;
  info.module = shader;
  info.pName = "main";
  return info;
}

constexpr std::uint32_t kFloat = sizeof(float);
constexpr std::array kBuffers{
    VkVertexInputBindingDescription{0, shared::kVertexFloats* kFloat, VK_VERTEX_INPUT_RATE_VERTEX},
    VkVertexInputBindingDescription{1, 2 * kFloat, VK_VERTEX_INPUT_RATE_VERTEX}};
constexpr std::array kAttributes{
    VkVertexInputAttributeDescription{0, 0, VK_FORMAT_R32G32B32_SFLOAT, 0},
    VkVertexInputAttributeDescription{1, 0, VK_FORMAT_R32G32B32_SFLOAT,
                                      shared::kNormalFloat* kFloat},
    VkVertexInputAttributeDescription{2, 0, VK_FORMAT_R32_SFLOAT, shared::kErrorFloat* kFloat},
    VkVertexInputAttributeDescription{3, 1, VK_FORMAT_R32G32_SFLOAT, 0}};

constexpr std::array kCrowdBuffers{
    VkVertexInputBindingDescription{0, 2 * kFloat, VK_VERTEX_INPUT_RATE_VERTEX},
    VkVertexInputBindingDescription{1, sizeof(vulkan::DrawnInstance),
                                    VK_VERTEX_INPUT_RATE_INSTANCE}};
constexpr std::array kCrowdAttributes{
    VkVertexInputAttributeDescription{0, 0, VK_FORMAT_R32G32_SFLOAT, 0},
    VkVertexInputAttributeDescription{1, 1, VK_FORMAT_R32G32_UINT, 0}};

VkPipelineVertexInputStateCreateInfo vertex_input(const Drawing& drawing) {
  VkPipelineVertexInputStateCreateInfo info{
      VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
  const auto take = [&](std::span<const VkVertexInputBindingDescription> buffers,
                        std::span<const VkVertexInputAttributeDescription> attributes) {
    info.vertexBindingDescriptionCount = static_cast<std::uint32_t>(buffers.size());
    info.pVertexBindingDescriptions = buffers.data();
    info.vertexAttributeDescriptionCount = static_cast<std::uint32_t>(attributes.size());
    info.pVertexAttributeDescriptions = attributes.data();
  };
  if (drawing.is_crowd)
    take(kCrowdBuffers, kCrowdAttributes);
  else if (drawing.has_uvs)
    take(kBuffers, kAttributes);
  else if (drawing.has_vertices)
    take(std::span(kBuffers).first(1), std::span(kAttributes).first(3));
  return info;
}

VkPipelineColorBlendAttachmentState blending(Blend blend) {
  VkPipelineColorBlendAttachmentState state{};
  const bool sums = blend == Blend::Sum;
  state.blendEnable = blend != Blend::None;
  state.srcColorBlendFactor = sums ? VK_BLEND_FACTOR_ONE : VK_BLEND_FACTOR_SRC_ALPHA;
  state.dstColorBlendFactor = sums ? VK_BLEND_FACTOR_ONE : VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA;
  state.srcAlphaBlendFactor = VK_BLEND_FACTOR_ONE;
  state.dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA;
  state.colorWriteMask = VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT |
                         VK_COLOR_COMPONENT_B_BIT | VK_COLOR_COMPONENT_A_BIT;
  return state;
}

OwnedComputePipeline make_kernel(VkDevice device, VkPipelineLayout layout, Words words) {
  const OwnedShader shader = make_shader(device, words);
  VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
  info.stage = stage(VK_SHADER_STAGE_COMPUTE_BIT, shader);
  info.layout = layout;
  return OwnedComputePipeline(device, info, "vkCreateComputePipelines");
}

VkShaderStageFlags patch_stages(const Device& device) {
  VkShaderStageFlags stages = VK_SHADER_STAGE_VERTEX_BIT;
  // A device that lacks it does not want to hear of it.
  if (device.has_tessellation()) stages |= VK_SHADER_STAGE_TESSELLATION_EVALUATION_BIT;
  return stages;
}

Drawing textured_drawing() {
  Drawing drawing{spirv::textured_vert, spirv::textured_frag, true};
  drawing.has_uvs = true;
  return drawing;
}

}  // namespace

VkShaderStageFlags push_stages(const Device& device) {
  return patch_stages(device) | VK_SHADER_STAGE_FRAGMENT_BIT | VK_SHADER_STAGE_COMPUTE_BIT;
}

OwnedSetLayout make_set_layout(VkDevice device, std::uint32_t count, VkShaderStageFlags stages) {
  std::vector<VkDescriptorSetLayoutBinding> bindings(count);
  for (std::uint32_t i = 0; i < count; ++i)
    bindings[i] = {i, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, stages, nullptr};
  VkDescriptorSetLayoutCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
  info.bindingCount = count;
  info.pBindings = bindings.data();
  return OwnedSetLayout(device, info, "vkCreateDescriptorSetLayout");
}

OwnedPipelineLayout make_layout(const Device& device, std::span<const VkDescriptorSetLayout> sets) {
  const VkPushConstantRange push{push_stages(device), 0, sizeof(shared::DrawParameters)};
  VkPipelineLayoutCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
  info.setLayoutCount = static_cast<std::uint32_t>(sets.size());
  info.pSetLayouts = sets.data();
  info.pushConstantRangeCount = 1;
  info.pPushConstantRanges = &push;
  return OwnedPipelineLayout(device, info, "vkCreatePipelineLayout");
}

VkDescriptorSet make_set(VkDevice device, VkDescriptorPool pool, VkDescriptorSetLayout layout,
                         std::span<const VkDescriptorBufferInfo> buffers) {
  VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
  allocate.descriptorPool = pool;
  allocate.descriptorSetCount = 1;
  allocate.pSetLayouts = &layout;
  VkDescriptorSet set = VK_NULL_HANDLE;
  vulkan::check(vkAllocateDescriptorSets(device, &allocate, &set), "vkAllocateDescriptorSets");
  VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
  write.dstSet = set;
  write.descriptorCount = static_cast<std::uint32_t>(buffers.size());
  write.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
  write.pBufferInfo = buffers.data();  // goes on from binding to binding
  vkUpdateDescriptorSets(device, 1, &write, 0, nullptr);
  return set;
}

OwnedGraphicsPipeline make_drawing(VkDevice device, VkRenderPass pass, VkPipelineLayout layout,
                                   const Drawing& drawing) {
  const OwnedShader vertex = make_shader(device, drawing.vertex);
  const OwnedShader fragment = make_shader(device, drawing.fragment);
  std::vector stages{stage(VK_SHADER_STAGE_VERTEX_BIT, vertex),
                     stage(VK_SHADER_STAGE_FRAGMENT_BIT, fragment)};
  const bool has_patches = !drawing.control.empty();
  OwnedShader control, evaluation;
  if (has_patches) {
    control = make_shader(device, drawing.control);
    evaluation = make_shader(device, drawing.evaluation);
    stages.push_back(stage(VK_SHADER_STAGE_TESSELLATION_CONTROL_BIT, control));
    stages.push_back(stage(VK_SHADER_STAGE_TESSELLATION_EVALUATION_BIT, evaluation));
  }
  VkPipelineTessellationStateCreateInfo tessellation{
      VK_STRUCTURE_TYPE_PIPELINE_TESSELLATION_STATE_CREATE_INFO};
  tessellation.patchControlPoints = 1;
  const auto input = vertex_input(drawing);
  VkPipelineInputAssemblyStateCreateInfo assembly{
      VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
  assembly.topology =
      has_patches ? VK_PRIMITIVE_TOPOLOGY_PATCH_LIST : VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
  VkPipelineViewportStateCreateInfo viewport{VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
  viewport.viewportCount = 1;
  viewport.scissorCount = 1;
  VkPipelineRasterizationStateCreateInfo raster{
      VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
  raster.frontFace = VK_FRONT_FACE_COUNTER_CLOCKWISE;
  raster.lineWidth = 1;
  VkPipelineMultisampleStateCreateInfo samples{
      VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
  samples.rasterizationSamples = kSamples;
  VkPipelineDepthStencilStateCreateInfo depth{
      VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO};
  depth.depthTestEnable = drawing.tests_depth;
  depth.depthWriteEnable = drawing.tests_depth;
  depth.depthCompareOp = VK_COMPARE_OP_LESS_OR_EQUAL;
  const VkPipelineColorBlendAttachmentState attachment = blending(drawing.blend);
  VkPipelineColorBlendStateCreateInfo blend{
      VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO};
  blend.attachmentCount = 1;
  blend.pAttachments = &attachment;
  constexpr std::array kDynamic{VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
  VkPipelineDynamicStateCreateInfo dynamic{VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO};
  dynamic.dynamicStateCount = kDynamic.size();
  dynamic.pDynamicStates = kDynamic.data();
  VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO};
  info.stageCount = static_cast<std::uint32_t>(stages.size());
  info.pStages = stages.data();
  info.pVertexInputState = &input;
  info.pInputAssemblyState = &assembly;
  if (has_patches) info.pTessellationState = &tessellation;
  info.pViewportState = &viewport;
  info.pRasterizationState = &raster;
  info.pMultisampleState = &samples;
  info.pDepthStencilState = &depth;
  info.pColorBlendState = &blend;
  info.pDynamicState = &dynamic;
  info.layout = layout;
  info.renderPass = pass;
  return OwnedGraphicsPipeline(device, info, "vkCreateGraphicsPipelines");
}

Pipelines::Pipelines(const Device& device, VkRenderPass pass)
    : set_layout(make_set_layout(device, shared::kBindingCount,
                                 VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_COMPUTE_BIT)),
      surface_layout(make_set_layout(device, shared::kSurfaceBindingCount, patch_stages(device))),
      layout(make_layout(device, std::array<VkDescriptorSetLayout, 2>{set_layout, surface_layout})),
      background(make_drawing(device, pass, layout,
                              {spirv::background_vert, spirv::background_frag, false, false})),
      surface(make_drawing(device, pass, layout, {spirv::surface_vert, spirv::surface_frag, true})),
      textured(make_drawing(device, pass, layout, textured_drawing())),
      edges(make_drawing(device, pass, layout,
                         {spirv::edge_vert, spirv::edge_frag, false, true, Blend::Over})),
      hidden_edges(make_drawing(device, pass, layout,
                                {spirv::edge_vert, spirv::edge_frag, false, false, Blend::Over})),
      points(make_drawing(device, pass, layout, {spirv::point_vert, spirv::point_frag})),
      vertex_error(make_kernel(device, layout, spirv::vertex_error_comp)) {
  if (!device.has_tessellation()) return;
  Drawing drawing{spirv::patch_vert, spirv::surface_frag};
  drawing.control = spirv::patch_tesc;
  drawing.evaluation = spirv::patch_tese;
  patches = make_drawing(device, pass, layout, drawing);
}

CrowdPipelines::CrowdPipelines(const Device& device, VkRenderPass pass, VkRenderPass motion_pass,
                               bool is_textured)
    : set_layout(make_set_layout(device, 2, VK_SHADER_STAGE_VERTEX_BIT)),
      layout(make_layout(device, std::array<VkDescriptorSetLayout, 1>{set_layout})) {
  Drawing drawing{spirv::crowd_vert,
                  is_textured ? Words(spirv::textured_frag) : Words(spirv::surface_frag)};
  drawing.is_crowd = true;
  surface = make_drawing(device, pass, layout, drawing);
  if (!motion_pass) return;
  drawing.fragment = spirv::motion_frag;
  motion = make_drawing(device, motion_pass, layout, drawing);
}

}  // namespace planish::viewer
