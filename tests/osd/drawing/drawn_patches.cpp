#include "osd/drawing/drawn_patches.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>

#include "planish/osd/vk_compute_evaluator.h"
#include "planish/vulkan/device/context.h"
#include "viewer/device.h"

namespace planish::testing {
namespace {

using OpenSubdiv::Osd::BufferDescriptor;
using namespace viewer;

constexpr VkDeviceSize kMostVertices = 400000;
// Mesa's llvmpipe (22.3) counts gl_PrimitiveID anew after so many control points of a draw.
constexpr int kPrimitiveIdRun = 1024;
constexpr vulkan::Scope kVertexInput{
    VK_PIPELINE_STAGE_VERTEX_INPUT_BIT | VK_PIPELINE_STAGE_TESSELLATION_CONTROL_SHADER_BIT |
        VK_PIPELINE_STAGE_TESSELLATION_EVALUATION_SHADER_BIT,
    VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT | VK_ACCESS_INDEX_READ_BIT | VK_ACCESS_SHADER_READ_BIT};
constexpr vulkan::Scope kCapture{VK_PIPELINE_STAGE_TRANSFORM_FEEDBACK_BIT_EXT,
                                 VK_ACCESS_TRANSFORM_FEEDBACK_WRITE_BIT_EXT |
                                     VK_ACCESS_TRANSFORM_FEEDBACK_COUNTER_WRITE_BIT_EXT};
constexpr vulkan::Scope kHost{VK_PIPELINE_STAGE_HOST_BIT, VK_ACCESS_HOST_READ_BIT};
constexpr VkShaderStageFlags kStages =
    VK_SHADER_STAGE_TESSELLATION_CONTROL_BIT | VK_SHADER_STAGE_TESSELLATION_EVALUATION_BIT;

// As drawing/view.glsl has it.
struct View {
  glm::mat4 clip_from_object;
  float level;
  VkBool32 by_screen;
  int first_patch;
};

// Without attachments: triangles are captured before they are drawn.
OwnedRenderPass make_empty_pass(VkDevice device) {
  VkSubpassDescription subpass{};
  subpass.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS;
  VkRenderPassCreateInfo info{VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO};
  info.subpassCount = 1;
  info.pSubpasses = &subpass;
  return OwnedRenderPass(device, info, "vkCreateRenderPass");
}

OwnedFramebuffer make_empty_framebuffer(VkDevice device, VkRenderPass pass) {
  VkFramebufferCreateInfo info{VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO};
  info.renderPass = pass;
  info.width = info.height = info.layers = 1;
  return OwnedFramebuffer(device, info, "vkCreateFramebuffer");
}

OwnedPipelineLayout make_patch_layout(VkDevice device, VkDescriptorSetLayout set) {
  const VkPushConstantRange push{kStages, 0, sizeof(View)};
  VkPipelineLayoutCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
  info.setLayoutCount = 1;
  info.pSetLayouts = &set;
  info.pushConstantRangeCount = 1;
  info.pPushConstantRanges = &push;
  return OwnedPipelineLayout(device, info, "vkCreatePipelineLayout");
}

OwnedDescriptorPool make_pool(VkDevice device) {
  const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1};
  VkDescriptorPoolCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
  info.maxSets = 1;
  info.poolSizeCount = 1;
  info.pPoolSizes = &size;
  return OwnedDescriptorPool(device, info, "vkCreateDescriptorPool");
}

template <class Function>
Function function(VkDevice device, const char* name) {
  return reinterpret_cast<Function>(vkGetDeviceProcAddr(device, name));
}

// As CMakeLists.txt names them.
constexpr const char* kSpacings[] = {"_equal", "_even", "_odd"};

OwnedShader make_shader(VkDevice device, const std::string& name) {
  std::ifstream file(PLANISH_DRAWING_SHADERS "/" + name + ".spv", std::ios::binary);
  const std::string code(std::istreambuf_iterator<char>(file), {});
  EXPECT_FALSE(code.empty()) << name;
  std::vector<std::uint32_t> words(code.size() / sizeof(std::uint32_t));
  std::memcpy(words.data(), code.data(), code.size());
  VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
  info.codeSize = code.size();
  info.pCode = words.data();
  return OwnedShader(device, info, "vkCreateShaderModule");
}

}  // namespace

DrawnMesh::DrawnMesh(const Cage& cage, const RefineOptions& options, osd::VkDeviceContext& target)
    : refined(refine(cage, options)),
      table(osd::VkPatchTable::Create(refined.patches.get(), &target)) {
  const int coarse = static_cast<int>(cage.positions.size());
  const int rows = refined.vertices->GetNumStencils();
  points.reset(osd::VkVertexBuffer::Create(3, coarse + rows, &target));
  points->UpdateData(cage.positions.front().data(), 0, coarse, &target);
  if (rows > 0) {
    const std::unique_ptr<osd::VkStencilTable> stencils(
        osd::VkStencilTable::Create(refined.vertices.get(), &target));
    EXPECT_TRUE(osd::VkComputeEvaluator::EvalStencils(
        points.get(), BufferDescriptor(0, 3, 3), points.get(), BufferDescriptor(3 * coarse, 3, 3),
        stencils.get(), nullptr, &target));
  }
  target.Synchronize();
}

PatchDrawing::PatchDrawing(const Device& device)
    : device_(device),
      context_(device.host()),
      target_(context_, device.queue(), device.family()),
      pass_(make_empty_pass(device)),
      framebuffer_(make_empty_framebuffer(device, pass_)),
      set_layout_(make_set_layout(device, 1, kStages)),
      layout_(make_patch_layout(device, set_layout_)),
      pool_(make_pool(device)),
      made_(device, kMostVertices * sizeof(DrawnVertex),
            VK_BUFFER_USAGE_TRANSFORM_FEEDBACK_BUFFER_BIT_EXT, Place::Host),
      byte_count_(device, sizeof(std::uint32_t),
                  VK_BUFFER_USAGE_TRANSFORM_FEEDBACK_COUNTER_BUFFER_BIT_EXT, Place::Host),
      bind_(function<PFN_vkCmdBindTransformFeedbackBuffersEXT>(
          device, "vkCmdBindTransformFeedbackBuffersEXT")),
      begin_(
          function<PFN_vkCmdBeginTransformFeedbackEXT>(device, "vkCmdBeginTransformFeedbackEXT")),
      end_(function<PFN_vkCmdEndTransformFeedbackEXT>(device, "vkCmdEndTransformFeedbackEXT")) {}

VkPipeline PatchDrawing::pipeline(const OpenSubdiv::Osd::PatchArray& array, Spacing spacing) {
  OwnedGraphicsPipeline& kept = pipelines_[{array.GetPatchType(), spacing}];
  if (kept != VkPipeline(VK_NULL_HANDLE)) return kept;
  const std::string which = std::to_string(array.GetPatchType()) + kSpacings[int(spacing)];
  const std::array shaders{make_shader(device_, "patch.vert"),
                           make_shader(device_, "patch_" + which + ".tesc"),
                           make_shader(device_, "patch_" + which + ".tese")};
  constexpr std::array kKinds{VK_SHADER_STAGE_VERTEX_BIT, VK_SHADER_STAGE_TESSELLATION_CONTROL_BIT,
                              VK_SHADER_STAGE_TESSELLATION_EVALUATION_BIT};
  std::array<VkPipelineShaderStageCreateInfo, 3> stages{};
  for (std::size_t i = 0; i < stages.size(); ++i) {
    stages[i].sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    stages[i].stage = kKinds[i];
    stages[i].module = shaders[i];
    stages[i].pName = "main";
  }
  const VkVertexInputBindingDescription binding{0, 3 * sizeof(float), VK_VERTEX_INPUT_RATE_VERTEX};
  const VkVertexInputAttributeDescription attribute{0, 0, VK_FORMAT_R32G32B32_SFLOAT, 0};
  VkPipelineVertexInputStateCreateInfo input{
      VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
  input.vertexBindingDescriptionCount = input.vertexAttributeDescriptionCount = 1;
  input.pVertexBindingDescriptions = &binding;
  input.pVertexAttributeDescriptions = &attribute;
  VkPipelineInputAssemblyStateCreateInfo assembly{
      VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
  assembly.topology = VK_PRIMITIVE_TOPOLOGY_PATCH_LIST;
  VkPipelineTessellationStateCreateInfo tessellation{
      VK_STRUCTURE_TYPE_PIPELINE_TESSELLATION_STATE_CREATE_INFO};
  tessellation.patchControlPoints = static_cast<std::uint32_t>(array.GetStride());
  VkPipelineRasterizationStateCreateInfo raster{
      VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
  raster.rasterizerDiscardEnable = VK_TRUE;
  raster.lineWidth = 1;
  VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO};
  info.stageCount = stages.size();
  info.pStages = stages.data();
  info.pVertexInputState = &input;
  info.pInputAssemblyState = &assembly;
  info.pTessellationState = &tessellation;
  info.pRasterizationState = &raster;
  info.layout = layout_;
  info.renderPass = pass_;
  kept = OwnedGraphicsPipeline(device_, info, "vkCreateGraphicsPipelines");
  return kept;
}

std::vector<DrawnVertex> PatchDrawing::draw(const DrawnMesh& mesh, const DrawOptions& options) {
  vulkan::check(vkResetDescriptorPool(device_, pool_, 0), "vkResetDescriptorPool");
  const VkDescriptorBufferInfo params{mesh.table->GetPatchParamBuffer(), 0, VK_WHOLE_SIZE};
  set_ = make_set(device_, pool_, set_layout_, {&params, 1});
  std::vector<DrawnVertex> vertices;
  for (const OpenSubdiv::Osd::PatchArray& array : mesh.table->GetPatchArrays()) {
    const int most = kPrimitiveIdRun / array.GetStride();
    for (int first = 0; first < array.GetNumPatches(); first += most) {
      const int count = std::min(most, array.GetNumPatches() - first);
      device_.run(
          [&](VkCommandBuffer commands) { record(commands, mesh, array, first, count, options); });
      std::uint32_t bytes = 0;
      std::memcpy(&bytes, byte_count_.mapped().data(), sizeof bytes);
      EXPECT_LT(bytes, made_.bytes());  // or some may be missing
      const auto* const made = reinterpret_cast<const DrawnVertex*>(made_.mapped().data());
      vertices.insert(vertices.end(), made, made + bytes / sizeof(DrawnVertex));
    }
  }
  return vertices;
}

void PatchDrawing::record(VkCommandBuffer commands, const DrawnMesh& mesh,
                          const OpenSubdiv::Osd::PatchArray& array, int first, int count,
                          const DrawOptions& options) {
  const VkBuffer points = mesh.points->BindVBO(), made = made_, byte_count = byte_count_;
  const VkDeviceSize start = 0, bytes = made_.bytes();
  barrier(commands, vulkan::kExitScope, kVertexInput);
  VkRenderPassBeginInfo begin{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
  begin.renderPass = pass_;
  begin.framebuffer = framebuffer_;
  begin.renderArea.extent = {1, 1};
  vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline(array, options.spacing));
  vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout_, 0, 1, &set_, 0,
                          nullptr);
  const View view{options.clip_from_object, options.level, options.by_screen,
                  array.GetPrimitiveIdBase() + first};
  vkCmdPushConstants(commands, layout_, kStages, 0, sizeof view, &view);
  vkCmdBindVertexBuffers(commands, 0, 1, &points, &start);
  vkCmdBindIndexBuffer(commands, mesh.table->GetPatchIndexBuffer(), 0, VK_INDEX_TYPE_UINT32);
  bind_(commands, 0, 1, &made, &start, &bytes);
  begin_(commands, 0, 0, nullptr, nullptr);
  const auto points_of = [&](int patches) {
    return static_cast<std::uint32_t>(patches * array.GetStride());
  };
  vkCmdDrawIndexed(commands, points_of(count), 1,
                   static_cast<std::uint32_t>(array.GetIndexBase()) + points_of(first), 0, 0);
  end_(commands, 0, 1, &byte_count, &start);
  vkCmdEndRenderPass(commands);
  barrier(commands, kCapture, kHost);
}

}  // namespace planish::testing
