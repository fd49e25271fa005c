#include "renderer.h"

#include <algorithm>
#include <array>
#include <utility>

namespace planish::viewer {
namespace {

constexpr vulkan::Scope kErrorScope{VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                                    VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT};
constexpr float kEdgeWidth = 1.5f, kPointWidth = 10;  // pixels of a picture of kWidthHeight
constexpr float kWidthHeight = 720;
constexpr float kHiddenAlpha = 0.16f;
constexpr std::uint32_t kQuadVertices = 6;
constexpr std::uint32_t kMostGroups = 65535;  // that every device takes

}  // namespace

Renderer::Renderer(const Device& device, VkRenderPass pass, Scene scene)
    : device_(device),
      scene_(std::move(scene)),
      animation_(scene_.mesh.positions),
      context_(device.host()),
      pipelines_(device, pass) {
  for (Slot& slot : slots_) slot = make_slot();
}

Renderer::~Renderer() {
  // Nothing can be done here about a device that is lost.
  vkDeviceWaitIdle(device_);
}

Renderer::Slot Renderer::make_slot() const {
  Slot slot;
  VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  pool.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT;
  pool.queueFamilyIndex = device_.family();
  slot.pool = OwnedCommandPool(device_, pool, "vkCreateCommandPool");
  VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  allocate.commandPool = slot.pool;
  allocate.commandBufferCount = 1;
  vulkan::check(vkAllocateCommandBuffers(device_, &allocate, &slot.commands),
                "vkAllocateCommandBuffers");
  const VkFenceCreateInfo fence{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
  slot.done = OwnedFence(device_, fence, "vkCreateFence");
  return slot;
}

void Renderer::wait_for(std::size_t index) {
  Slot& slot = slots_[index];
  if (!slot.submitted) return;
  vulkan::check(vkWaitForFences(device_, 1, slot.done.address(), VK_TRUE, UINT64_MAX),
                "vkWaitForFences");
  vulkan::check(vkResetFences(device_, 1, slot.done.address()), "vkResetFences");
  slot.submitted = false;
  status_ = frames_[index]->status();
}

void Renderer::prepare(int level) {
  if (!model_ || has_other_mesh_ || model_->system().level() != level) build(level);
  wait_for((current_ + 1) % kFramesInFlight);
}

void Renderer::set_mesh(PolygonMesh mesh) {
  scene_.mesh = std::move(mesh);
  scene_.system.fair_decisions = nullptr;  // which were by the rules before
  has_other_mesh_ = true;
}

void Renderer::finish() {
  // The older first, so that the last status is the latest.
  wait_for((current_ + 1) % kFramesInFlight);
  wait_for(current_);
}

void Renderer::build(int level) {
  finish();
  scene_.system.level = level;
  scene_.system.textured = !scene_.mesh.uvs.empty();
  auto model = std::make_unique<Model>(device_, context_, scene_);
  decltype(frames_) frames;
  for (auto& frame : frames) frame = std::make_unique<Frame>(device_, context_, *model);
  vulkan::SolveOptions options;
  options.max_iterations = kMostIterations;
  options.given = frames[0]->slot().given;
  options.vertices = frames[0]->slot().vertices;
  for (std::size_t i = 1; i < frames.size(); ++i)
    options.further_slots.push_back(frames[i]->slot());
  auto solve = std::make_unique<vulkan::Solve>(context_, model->tables(), options);
  for (auto& frame : frames) frame->bind(device_, *model, pipelines_, *solve);
  solve_ = std::move(solve);
  frames_ = std::move(frames);
  model_ = std::move(model);
  is_warm_ = false;
  has_other_mesh_ = false;
}

VkCommandBuffer Renderer::begin_commands() {
  wait_for(current_);
  Slot& slot = slots_[current_];
  vulkan::check(vkResetCommandPool(device_, slot.pool, 0), "vkResetCommandPool");
  const VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO, nullptr,
                                       VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
  vulkan::check(vkBeginCommandBuffer(slot.commands, &begin), "vkBeginCommandBuffer");
  return slot.commands;
}

VkCommandBuffer Renderer::begin_next() {
  current_ = (current_ + 1) % kFramesInFlight;
  return begin_commands();
}

VkCommandBuffer Renderer::begin_frame(double seconds, const ViewSettings& settings) {
  const VkCommandBuffer commands = begin_next();
  animation_.pose(seconds, frames_[current_]->points());
  record_surface(commands, settings);
  return commands;
}

VkCommandBuffer Renderer::begin_frame(std::span<const glm::dvec3> points,
                                      const ViewSettings& settings) {
  const VkCommandBuffer commands = begin_next();
  std::ranges::transform(points, frames_[current_]->points().begin(),
                         [](const glm::dvec3& p) { return glm::vec3(p); });
  record_surface(commands, settings);
  return commands;
}

VkCommandBuffer Renderer::begin_redraw() {
  finish();
  return begin_commands();
}

vulkan::Scope Renderer::vertex_scope() const {
  vulkan::Scope scope{VK_PIPELINE_STAGE_VERTEX_INPUT_BIT | VK_PIPELINE_STAGE_VERTEX_SHADER_BIT,
                      VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT | VK_ACCESS_SHADER_READ_BIT};
  if (device_.has_tessellation())
    scope.stages |= VK_PIPELINE_STAGE_TESSELLATION_EVALUATION_SHADER_BIT;
  return scope;
}

void Renderer::record_surface(VkCommandBuffer commands, const ViewSettings& settings) {
  const Frame& frame = *frames_[current_];
  vulkan::SolveParameters parameters;
  parameters.iterations = static_cast<std::uint32_t>(settings.iterations);
  parameters.warm_start = settings.warm_start && is_warm_;
  parameters.measures_last = true;  // which is what the window says
  parameters.slot = static_cast<std::uint32_t>(current_);
  is_warm_ = true;
  // The last frame may still draw the cage, which all frames share.
  barrier(commands, vertex_scope(), vulkan::kEntryScope);
  solve_->record_solve(commands, parameters);
  if (settings.draws_patches())
    solve_->record_surface(commands);
  else
    solve_->record_evaluate(commands, {.slot = parameters.slot});
  solve_->record_status(commands, frame.status_target(), 0);
  host_barrier(commands);
  if (settings.heat) {
    barrier(commands, vulkan::kExitScope, kErrorScope);
    record_errors(commands);
  }
  barrier(commands, vulkan::kExitScope, vertex_scope());
}

void Renderer::record_errors(VkCommandBuffer commands) const {
  const auto vertices = static_cast<std::uint32_t>(system().vertex_count());
  const VkDescriptorSet set = frames_[current_]->set();
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines_.vertex_error);
  vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines_.layout, 0, 1, &set,
                          0, nullptr);
  vkCmdPushConstants(commands, pipelines_.layout, push_stages(device_), 0, sizeof vertices,
                     &vertices);
  const std::uint32_t groups = (vertices + shared::kErrorGroup - 1) / shared::kErrorGroup;
  vkCmdDispatch(commands, std::min(groups, kMostGroups), 1, 1);
}

void Renderer::draw(VkCommandBuffer commands, const OrbitCamera& camera, VkExtent2D extent,
                    const ViewSettings& settings) const {
  const Frame& frame = *frames_[current_];
  const float aspect = static_cast<float>(extent.width) / static_cast<float>(extent.height);
  shared::DrawParameters parameters{};
  parameters.clip_from_world = camera.clip_from_world(aspect);
  parameters.eye = camera.eye(aspect);
  parameters.diagonal = static_cast<float>(model_->system().diagonal());
  parameters.key = camera.key_light();
  parameters.heat = settings.heat;
  parameters.face_count = model_->face_count();
  parameters.is_software = device_.is_software();
  parameters.viewport = {extent.width, extent.height};
  const float pixel = static_cast<float>(extent.height) / kWidthHeight;
  const auto bind = [&](VkPipeline pipeline, float width, float alpha) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
    parameters.width = width * pixel;
    parameters.alpha = alpha;
    vkCmdPushConstants(commands, pipelines_.layout, push_stages(device_), 0, sizeof parameters,
                       &parameters);
  };
  const VkDescriptorSet set = frame.set();
  vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipelines_.layout, 0, 1, &set,
                          0, nullptr);
  bind(pipelines_.background, 0, 1);
  vkCmdDraw(commands, 3, 1, 0, 0);
  if (settings.surface && settings.draws_patches()) {
    const VkDescriptorSet surface = frame.surface_set();
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipelines_.layout,
                            shared::kSurfaceSet, 1, &surface, 0, nullptr);
    bind(pipelines_.patches, 0, 1);
    for (const Model::Run& run : model_->patches())
      vkCmdDraw(commands, run.count, 1, run.first, run.end);
  } else if (settings.surface) {
    const bool is_textured = settings.draws_squares() && model_->uvs() != VK_NULL_HANDLE;
    const std::array<VkBuffer, 2> vertices{frame.vertices(), model_->uvs()};
    constexpr std::array<VkDeviceSize, 2> kStarts{};
    bind(is_textured ? pipelines_.textured : pipelines_.surface, 0, 1);
    vkCmdBindVertexBuffers(commands, 0, is_textured ? 2 : 1, vertices.data(), kStarts.data());
    vkCmdBindIndexBuffer(commands, model_->indices(), 0, VK_INDEX_TYPE_UINT32);
    vkCmdDrawIndexed(commands, model_->tables().index_count(), 1, 0, 0, 0);
  }
  if (settings.cage) {
    bind(pipelines_.hidden_edges, kEdgeWidth, kHiddenAlpha);
    vkCmdDraw(commands, kQuadVertices, model_->edge_count(), 0, 0);
    bind(pipelines_.edges, kEdgeWidth, 1);
    vkCmdDraw(commands, kQuadVertices, model_->edge_count(), 0, 0);
  }
  if (settings.points) {
    bind(pipelines_.points, kPointWidth, 1);
    vkCmdDraw(commands, kQuadVertices, model_->used_count(), 0, 0);
  }
}

void Renderer::end_frame(const FrameSemaphores& semaphores) {
  Slot& slot = slots_[current_];
  vulkan::check(vkEndCommandBuffer(slot.commands), "vkEndCommandBuffer");
  const VkPipelineStageFlags stage = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT;
  VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
  submit.commandBufferCount = 1;
  submit.pCommandBuffers = &slot.commands;
  if (semaphores.image_ready) {
    submit.waitSemaphoreCount = 1;
    submit.pWaitSemaphores = &semaphores.image_ready;
    submit.pWaitDstStageMask = &stage;
  }
  if (semaphores.drawn) {
    submit.signalSemaphoreCount = 1;
    submit.pSignalSemaphores = &semaphores.drawn;
  }
  vulkan::check(vkQueueSubmit(device_.queue(), 1, &submit, slot.done), "vkQueueSubmit");
  slot.submitted = true;
}

}  // namespace planish::viewer
