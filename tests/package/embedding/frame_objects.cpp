#include "frame_objects.h"

#define MAKE(handle, create, destroy, info)                                 \
  check(LOAD(app_, create)(app_.device, &info, nullptr, &handle), #create); \
  keep(handle, LOAD(app_, destroy))

FrameObjects::~FrameObjects() {
  LOAD(app_, vkDeviceWaitIdle)(app_.device);
  for (auto destroy = destroy_.rbegin(); destroy != destroy_.rend(); ++destroy) (*destroy)();
}

VkImageView FrameObjects::make_image(std::uint32_t side, VkFormat format, VkImageUsageFlags usage,
                                     VkImageAspectFlags aspect, VkImage& image) {
  VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
  info.imageType = VK_IMAGE_TYPE_2D;
  info.format = format;
  info.extent = {side, side, 1};
  info.mipLevels = info.arrayLayers = 1;
  info.samples = VK_SAMPLE_COUNT_1_BIT;
  info.usage = usage | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
  MAKE(image, vkCreateImage, vkDestroyImage, info);
  VkMemoryRequirements needed;
  LOAD(app_, vkGetImageMemoryRequirements)(app_.device, image, &needed);
  VkMemoryAllocateInfo allocate{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
  allocate.allocationSize = needed.size;
  allocate.memoryTypeIndex =
      app_.memory_type(needed.memoryTypeBits, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
  VkDeviceMemory memory;
  MAKE(memory, vkAllocateMemory, vkFreeMemory, allocate);
  check(LOAD(app_, vkBindImageMemory)(app_.device, image, memory, 0), "vkBindImageMemory");
  VkImageViewCreateInfo view_info{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
  view_info.image = image;
  view_info.viewType = VK_IMAGE_VIEW_TYPE_2D;
  view_info.format = format;
  view_info.subresourceRange = {aspect, 0, 1, 0, 1};
  VkImageView view;
  MAKE(view, vkCreateImageView, vkDestroyImageView, view_info);
  return view;
}

VkRenderPass FrameObjects::make_render_pass(const Pass& pass) {
  std::vector<VkAttachmentDescription> attachments;
  std::vector<VkAttachmentReference> references;
  for (const VkFormat format : pass.formats) {
    const bool is_depth = format == VK_FORMAT_D32_SFLOAT;
    attachments.push_back({0, format, VK_SAMPLE_COUNT_1_BIT, VK_ATTACHMENT_LOAD_OP_CLEAR,
                           VK_ATTACHMENT_STORE_OP_STORE, VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                           VK_ATTACHMENT_STORE_OP_DONT_CARE, VK_IMAGE_LAYOUT_UNDEFINED,
                           VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL});
    references.push_back({static_cast<std::uint32_t>(references.size()),
                          is_depth ? VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL
                                   : VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL});
  }
  VkSubpassDescription subpass{};
  subpass.colorAttachmentCount = static_cast<std::uint32_t>(references.size()) - 1;
  subpass.pColorAttachments = references.data();
  subpass.pDepthStencilAttachment = &references.back();
  // The frames share the images: drawn after the last frame's copies, copied after they were drawn.
  constexpr VkPipelineStageFlags kDraws = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT |
                                          VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT |
                                          VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT;
  constexpr VkAccessFlags kWrites =
      VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
  const VkSubpassDependency dependencies[] = {
      {VK_SUBPASS_EXTERNAL, 0, VK_PIPELINE_STAGE_TRANSFER_BIT | kDraws, kDraws, kWrites,
       kWrites | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT, 0},
      {0, VK_SUBPASS_EXTERNAL, kDraws, VK_PIPELINE_STAGE_TRANSFER_BIT, kWrites,
       VK_ACCESS_TRANSFER_READ_BIT, 0}};
  VkRenderPassCreateInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO};
  info.attachmentCount = static_cast<std::uint32_t>(attachments.size());
  info.pAttachments = attachments.data();
  info.subpassCount = 1;
  info.pSubpasses = &subpass;
  info.dependencyCount = 2;
  info.pDependencies = dependencies;
  VkRenderPass result;
  MAKE(result, vkCreateRenderPass, vkDestroyRenderPass, info);
  return result;
}

VkShaderModule FrameObjects::make_module(std::span<const std::uint32_t> code) {
  VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
  info.codeSize = code.size_bytes();
  info.pCode = code.data();
  VkShaderModule module;
  MAKE(module, vkCreateShaderModule, vkDestroyShaderModule, info);
  return module;
}

VkPipelineLayout FrameObjects::make_layout(VkShaderStageFlags stages, std::uint32_t parameter_bytes,
                                           VkDescriptorSetLayout sets) {
  const VkPushConstantRange parameters{stages, 0, parameter_bytes};
  VkPipelineLayoutCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
  info.setLayoutCount = sets ? 1 : 0;
  info.pSetLayouts = &sets;
  info.pushConstantRangeCount = 1;
  info.pPushConstantRanges = &parameters;
  VkPipelineLayout layout;
  MAKE(layout, vkCreatePipelineLayout, vkDestroyPipelineLayout, info);
  return layout;
}

Pass FrameObjects::make_pass(std::uint32_t side, std::initializer_list<VkFormat> colours,
                             const Stages& code, std::initializer_list<std::uint32_t> strides,
                             std::initializer_list<Attribute> attributes,
                             std::uint32_t parameter_bytes,
                             const std::vector<VkDescriptorBufferInfo>& buffers) {
  Pass result;
  std::vector<VkImageView> views;
  result.formats = colours;
  result.formats.push_back(VK_FORMAT_D32_SFLOAT);
  for (const VkFormat format : result.formats) {
    const bool is_depth = format == VK_FORMAT_D32_SFLOAT;
    views.push_back(make_image(side, format,
                               is_depth ? VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT
                                        : VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT,
                               is_depth ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT,
                               result.images.emplace_back()));
  }
  result.pass = make_render_pass(result);
  VkFramebufferCreateInfo frame{VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO};
  frame.renderPass = result.pass;
  frame.attachmentCount = static_cast<std::uint32_t>(views.size());
  frame.pAttachments = views.data();
  frame.width = frame.height = side;
  frame.layers = 1;
  MAKE(result.framebuffer, vkCreateFramebuffer, vkDestroyFramebuffer, frame);
  const bool has_patches = !code.control.empty();
  result.parameter_stages =
      VK_SHADER_STAGE_VERTEX_BIT | (has_patches ? VK_SHADER_STAGE_TESSELLATION_EVALUATION_BIT : 0);
  std::vector<VkDescriptorSet> sets;
  const VkDescriptorSetLayout set_layout =
      buffers.empty() ? VK_NULL_HANDLE : make_sets(result.parameter_stages, {buffers}, sets);
  if (!sets.empty()) result.set = sets.front();
  result.layout = make_layout(result.parameter_stages, parameter_bytes, set_layout);

  std::vector<VkPipelineShaderStageCreateInfo> stages;
  const auto add_stage = [&](VkShaderStageFlagBits stage, std::span<const std::uint32_t> words) {
    if (words.empty()) return;
    VkPipelineShaderStageCreateInfo& made = stages.emplace_back(
        VkPipelineShaderStageCreateInfo{VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO});
    made.stage = stage;
    made.module = make_module(words);
    made.pName = "main";
  };
  add_stage(VK_SHADER_STAGE_VERTEX_BIT, code.vertex);
  add_stage(VK_SHADER_STAGE_TESSELLATION_CONTROL_BIT, code.control);
  add_stage(VK_SHADER_STAGE_TESSELLATION_EVALUATION_BIT, code.evaluation);
  add_stage(VK_SHADER_STAGE_FRAGMENT_BIT, code.fragment);
  std::vector<VkVertexInputBindingDescription> bindings;
  for (const std::uint32_t stride : strides)
    bindings.push_back(
        {static_cast<std::uint32_t>(bindings.size()), stride, VK_VERTEX_INPUT_RATE_VERTEX});
  std::vector<VkVertexInputAttributeDescription> inputs;
  for (const Attribute& attribute : attributes)
    inputs.push_back({static_cast<std::uint32_t>(inputs.size()), attribute.binding,
                      attribute.format, attribute.offset});
  VkPipelineVertexInputStateCreateInfo input{
      VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
  input.vertexBindingDescriptionCount = static_cast<std::uint32_t>(bindings.size());
  input.pVertexBindingDescriptions = bindings.data();
  input.vertexAttributeDescriptionCount = static_cast<std::uint32_t>(inputs.size());
  input.pVertexAttributeDescriptions = inputs.data();
  VkPipelineInputAssemblyStateCreateInfo assembly{
      VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
  assembly.topology =
      has_patches ? VK_PRIMITIVE_TOPOLOGY_PATCH_LIST : VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
  VkPipelineTessellationStateCreateInfo patches{
      VK_STRUCTURE_TYPE_PIPELINE_TESSELLATION_STATE_CREATE_INFO};
  patches.patchControlPoints = 1;
  const VkViewport viewport{0, 0, float(side), float(side), 0, 1};
  const VkRect2D scissor{{0, 0}, {side, side}};
  VkPipelineViewportStateCreateInfo view{VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
  view.viewportCount = view.scissorCount = 1;
  view.pViewports = &viewport;
  view.pScissors = &scissor;
  VkPipelineRasterizationStateCreateInfo raster{
      VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
  raster.lineWidth = 1;
  // Where a crack were, the background would be seen.
  if (has_patches) raster.cullMode = VK_CULL_MODE_BACK_BIT;
  VkPipelineMultisampleStateCreateInfo samples{
      VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
  samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
  VkPipelineDepthStencilStateCreateInfo depth{
      VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO};
  depth.depthTestEnable = depth.depthWriteEnable = VK_TRUE;
  depth.depthCompareOp = VK_COMPARE_OP_LESS;
  VkPipelineColorBlendAttachmentState all{};
  all.colorWriteMask = 0xf;
  const std::vector<VkPipelineColorBlendAttachmentState> blends(colours.size(), all);
  VkPipelineColorBlendStateCreateInfo blend{
      VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO};
  blend.attachmentCount = static_cast<std::uint32_t>(blends.size());
  blend.pAttachments = blends.data();
  VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO};
  info.stageCount = static_cast<std::uint32_t>(stages.size());
  info.pStages = stages.data();
  info.pVertexInputState = &input;
  info.pInputAssemblyState = &assembly;
  info.pTessellationState = has_patches ? &patches : nullptr;
  info.pViewportState = &view;
  info.pRasterizationState = &raster;
  info.pMultisampleState = &samples;
  info.pDepthStencilState = &depth;
  info.pColorBlendState = &blend;
  info.layout = result.layout;
  info.renderPass = result.pass;
  check(LOAD(app_, vkCreateGraphicsPipelines)(app_.device, VK_NULL_HANDLE, 1, &info, nullptr,
                                              &result.pipeline),
        "vkCreateGraphicsPipelines");
  keep(result.pipeline, LOAD(app_, vkDestroyPipeline));
  return result;
}

VkDescriptorSetLayout FrameObjects::make_sets(
    VkShaderStageFlags stages, const std::vector<std::vector<VkDescriptorBufferInfo>>& buffers,
    std::vector<VkDescriptorSet>& sets) {
  const auto count = static_cast<std::uint32_t>(buffers.front().size());
  const auto set_count = static_cast<std::uint32_t>(buffers.size());
  std::vector<VkDescriptorSetLayoutBinding> bindings;
  for (std::uint32_t i = 0; i < count; ++i)
    bindings.push_back({i, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, stages, nullptr});
  VkDescriptorSetLayoutCreateInfo set_info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
  set_info.bindingCount = count;
  set_info.pBindings = bindings.data();
  VkDescriptorSetLayout layout;
  MAKE(layout, vkCreateDescriptorSetLayout, vkDestroyDescriptorSetLayout, set_info);
  const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, count * set_count};
  VkDescriptorPoolCreateInfo pool_info{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
  pool_info.maxSets = set_count;
  pool_info.poolSizeCount = 1;
  pool_info.pPoolSizes = &size;
  VkDescriptorPool pool;
  MAKE(pool, vkCreateDescriptorPool, vkDestroyDescriptorPool, pool_info);
  for (const std::vector<VkDescriptorBufferInfo>& of_set : buffers) {
    VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
    allocate.descriptorPool = pool;
    allocate.descriptorSetCount = 1;
    allocate.pSetLayouts = &layout;
    check(LOAD(app_, vkAllocateDescriptorSets)(app_.device, &allocate, &sets.emplace_back()),
          "vkAllocateDescriptorSets");
    VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
    write.dstSet = sets.back();
    write.descriptorCount = count;  // from binding to binding
    write.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    write.pBufferInfo = of_set.data();
    LOAD(app_, vkUpdateDescriptorSets)(app_.device, 1, &write, 0, nullptr);
  }
  return layout;
}

Kernel FrameObjects::make_kernel(std::span<const std::uint32_t> code, std::uint32_t parameter_bytes,
                                 const std::vector<std::vector<VkBuffer>>& sets) {
  std::vector<std::vector<VkDescriptorBufferInfo>> buffers(sets.size());
  for (std::size_t i = 0; i < sets.size(); ++i)
    for (const VkBuffer buffer : sets[i]) buffers[i].push_back({buffer, 0, VK_WHOLE_SIZE});
  Kernel result;
  const VkDescriptorSetLayout set_layout =
      make_sets(VK_SHADER_STAGE_COMPUTE_BIT, buffers, result.sets);
  result.layout = make_layout(VK_SHADER_STAGE_COMPUTE_BIT, parameter_bytes, set_layout);
  VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
  info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
  info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  info.stage.module = make_module(code);
  info.stage.pName = "main";
  info.layout = result.layout;
  check(LOAD(app_, vkCreateComputePipelines)(app_.device, VK_NULL_HANDLE, 1, &info, nullptr,
                                             &result.pipeline),
        "vkCreateComputePipelines");
  keep(result.pipeline, LOAD(app_, vkDestroyPipeline));
  return result;
}

VkCommandBuffer FrameObjects::make_commands() {
  if (!pool_) {
    VkCommandPoolCreateInfo info{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
    info.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
    info.queueFamilyIndex = app_.family;
    MAKE(pool_, vkCreateCommandPool, vkDestroyCommandPool, info);
  }
  VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  allocate.commandPool = pool_;
  allocate.commandBufferCount = 1;
  VkCommandBuffer commands;
  check(LOAD(app_, vkAllocateCommandBuffers)(app_.device, &allocate, &commands),
        "vkAllocateCommandBuffers");
  return commands;
}

VkFence FrameObjects::make_fence() {
  VkFenceCreateInfo info{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
  VkFence fence;
  MAKE(fence, vkCreateFence, vkDestroyFence, info);
  return fence;
}
