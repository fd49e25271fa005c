#include "viewer/watched_patches.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "generated/layers.frag.spv.h"
#include "generated/patch.tesc.spv.h"
#include "generated/patch.vert.spv.h"
#include "generated/watched_patch.tese.spv.h"

namespace planish::testing {
namespace {

using namespace viewer;

constexpr VkFormat kFormat = VK_FORMAT_R8G8B8A8_UNORM;
constexpr VkDeviceSize kMostVertices = 2000000;

Scene scene_of(const PolygonMesh& mesh) {
  Scene scene;
  scene.mesh = mesh;
  scene.system.level = 0;
  return scene;
}

template <class Function>
Function function(VkDevice device, const char* name) {
  return reinterpret_cast<Function>(vkGetDeviceProcAddr(device, name));
}

constexpr vulkan::Scope kCapture{VK_PIPELINE_STAGE_TRANSFORM_FEEDBACK_BIT_EXT,
                                 VK_ACCESS_TRANSFORM_FEEDBACK_WRITE_BIT_EXT |
                                     VK_ACCESS_TRANSFORM_FEEDBACK_COUNTER_WRITE_BIT_EXT};
constexpr vulkan::Scope kHost{VK_PIPELINE_STAGE_HOST_BIT, VK_ACCESS_HOST_READ_BIT};

}  // namespace

WatchedPatches::WatchedPatches(const Device& device, const PolygonMesh& mesh, VkExtent2D extent)
    : device_(device),
      extent_(extent),
      pass_(make_render_pass(device, {kFormat, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL})),
      image_(device, {kFormat, extent, VK_SAMPLE_COUNT_1_BIT,
                      VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                      VK_IMAGE_ASPECT_COLOR_BIT}),
      targets_(device, pass_, kFormat, extent, std::array{image_.view()}),
      context_(device.host()),
      pipelines_(device, pass_),
      model_(device, context_, scene_of(mesh)),
      frame_(device, context_, model_),
      made_(device, kMostVertices * sizeof(PatchVertex),
            VK_BUFFER_USAGE_TRANSFORM_FEEDBACK_BUFFER_BIT_EXT, Place::Host),
      byte_count_(device, sizeof(std::uint32_t),
                  VK_BUFFER_USAGE_TRANSFORM_FEEDBACK_COUNTER_BUFFER_BIT_EXT, Place::Host),
      picture_(device, VkDeviceSize{4} * extent.width * extent.height,
               VK_BUFFER_USAGE_TRANSFER_DST_BIT, Place::Host),
      bind_(function<PFN_vkCmdBindTransformFeedbackBuffersEXT>(
          device, "vkCmdBindTransformFeedbackBuffersEXT")),
      begin_(
          function<PFN_vkCmdBeginTransformFeedbackEXT>(device, "vkCmdBeginTransformFeedbackEXT")),
      end_(function<PFN_vkCmdEndTransformFeedbackEXT>(device, "vkCmdEndTransformFeedbackEXT")) {
  viewer::Drawing drawing{viewer::spirv::patch_vert, spirv::layers_frag, false, false, Blend::Sum};
  drawing.control = viewer::spirv::patch_tesc;
  drawing.evaluation = spirv::watched_patch_tese;
  pipeline_ = make_drawing(device, pass_, pipelines_.layout, drawing);
  vulkan::SolveOptions options;
  options.given = frame_.slot().given;
  options.vertices = frame_.slot().vertices;
  solve_ = std::make_unique<vulkan::Solve>(context_, model_.tables(), options);
  frame_.bind(device, model_, pipelines_, *solve_);
  std::ranges::transform(mesh.positions, frame_.points().begin(),
                         [](const glm::dvec3& p) { return glm::vec3(p); });
  device.run([&](VkCommandBuffer commands) {
    solve_->record_solve(commands, {.iterations = 0});
    solve_->record_surface(commands);
  });
}

void WatchedPatches::draw(const OrbitCamera& camera) {
  const float aspect = static_cast<float>(extent_.width) / static_cast<float>(extent_.height);
  shared::DrawParameters parameters{};
  parameters.clip_from_world = camera.clip_from_world(aspect);
  parameters.viewport = {extent_.width, extent_.height};
  parameters.face_count = model_.face_count();
  parameters.is_software = device_.is_software();
  const std::array sets{frame_.set(), frame_.surface_set()};
  const VkBuffer made = made_, byte_count = byte_count_;
  const VkDeviceSize start = 0, bytes = made_.bytes();
  device_.run([&](VkCommandBuffer commands) {
    targets_.begin(commands, 0);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline_);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipelines_.layout, 0,
                            sets.size(), sets.data(), 0, nullptr);
    vkCmdPushConstants(commands, pipelines_.layout, push_stages(device_), 0, sizeof parameters,
                       &parameters);
    bind_(commands, 0, 1, &made, &start, &bytes);
    begin_(commands, 0, 0, nullptr, nullptr);
    for (const Model::Run& run : model_.patches())
      vkCmdDraw(commands, run.count, 1, run.first, run.end);
    end_(commands, 0, 1, &byte_count, &start);
    vkCmdEndRenderPass(commands);
    barrier(commands, kCapture, kHost);
    VkBufferImageCopy region{};
    region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    region.imageExtent = {extent_.width, extent_.height, 1};
    vkCmdCopyImageToBuffer(commands, image_, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, picture_, 1,
                           &region);
    host_barrier(commands);
  });
}

std::span<const PatchVertex> WatchedPatches::vertices() const {
  std::uint32_t bytes = 0;
  std::memcpy(&bytes, byte_count_.mapped().data(), sizeof bytes);
  EXPECT_LT(bytes, made_.bytes());  // or some may be missing
  return {reinterpret_cast<const PatchVertex*>(made_.mapped().data()), bytes / sizeof(PatchVertex)};
}

std::span<const std::array<std::uint8_t, 4>> WatchedPatches::layers() const {
  return {reinterpret_cast<const std::array<std::uint8_t, 4>*>(picture_.mapped().data()),
          std::size_t{extent_.width} * extent_.height};
}

}  // namespace planish::testing
