#include "renderer.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <numeric>
#include <set>
#include <span>
#include <string>
#include <utility>

#include "planish/core/error.h"
#include "planish/surface/level_one_mesh.h"

namespace planish::viewer {
namespace {

constexpr std::uint32_t kNoPoint = ~0u;

// Each edge of the mesh once; `point_of` tells which control point a vertex is.
std::vector<std::uint32_t> edges_of(const PolygonMesh& mesh,
                                    std::span<const std::uint32_t> point_of) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    for (std::size_t k = 0; k < face.size(); ++k) {
      const auto [a, b] = std::minmax(point_of[face[k]], point_of[face[(k + 1) % face.size()]]);
      if (b != kNoPoint) edges.emplace(a, b);
    }
  }
  std::vector<std::uint32_t> flat;
  for (const auto& [a, b] : edges) flat.insert(flat.end(), {a, b});
  return flat;
}

}  // namespace

std::vector<std::uint32_t> cage_edges(const Scene& scene, std::span<const std::int32_t> used) {
  if (scene.system.method == InterpolationMethod::Progressive) {
    std::vector<std::uint32_t> row_of(scene.mesh.positions.size());
    for (std::size_t row = 0; row < used.size(); ++row)
      row_of[used[row]] = static_cast<std::uint32_t>(row);
    return edges_of(scene.mesh, row_of);
  }
  const SubdividedMesh base(scene.mesh, scene.system.sharp);
  LevelOne level_one;
  level_one.state.resize(static_cast<std::size_t>(base.subdivision.state_size()));
  const PolygonMesh net = level_one_mesh(base, level_one);
  // Where holes cut polygons there are more vertices, which are no control points.
  std::vector<std::uint32_t> point_of(net.positions.size(), kNoPoint);
  std::iota(point_of.begin(), point_of.begin() + std::ssize(level_one.state), 0u);
  return edges_of(net, point_of);
}

namespace {

// Neighbours along the edges of the surface's quads, of its triangles at level 0.
std::vector<std::vector<std::uint32_t>> neighbours(const vulkan::System& system,
                                                   std::span<const std::int32_t> original) {
  const bool has_quads = !system.quads().empty();
  const std::span<const std::uint32_t> corners = has_quads ? system.quads() : system.triangles();
  const std::size_t size = has_quads ? 4 : 3;
  std::vector<std::vector<std::uint32_t>> result(system.vertex_count());
  for (std::size_t face = 0; face < corners.size(); face += size)
    for (std::size_t k = 0; k < size; ++k) {
      const auto a = static_cast<std::uint32_t>(original[corners[face + k]]);
      const auto b = static_cast<std::uint32_t>(original[corners[face + (k + 1) % size]]);
      result[a].push_back(b);
      result[b].push_back(a);
    }
  return result;
}

}  // namespace

NearestGiven nearest_given(const vulkan::System& system) {
  const std::span<const std::int32_t> original = system.copied_vertices();
  const auto adjacent = neighbours(system, original);
  const auto given_count = static_cast<std::uint32_t>(system.used_vertices().size());
  constexpr int kFar = -1;
  std::vector<std::vector<std::uint32_t>> rows(system.vertex_count());
  std::vector<int> steps(rows.size(), kFar);
  std::vector<std::uint32_t> reached(given_count);
  std::iota(reached.begin(), reached.end(), 0u);
  for (const std::uint32_t row : reached) {
    rows[row] = {row};
    steps[row] = 0;
  }
  for (int step = 1; !reached.empty(); ++step) {
    std::vector<std::uint32_t> next;
    for (const std::uint32_t from : reached)
      for (const std::uint32_t to : adjacent[from]) {
        if (steps[to] == kFar) {
          steps[to] = step;
          next.push_back(to);
        }
        if (steps[to] != step) continue;
        for (const std::uint32_t row : rows[from])
          if (std::ranges::find(rows[to], row) == rows[to].end()) rows[to].push_back(row);
      }
    reached = std::move(next);
  }
  NearestGiven result{{0}, {}};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto& nearest = rows[original[i]];
    result.rows.insert(result.rows.end(), nearest.begin(), nearest.end());
    result.offsets.push_back(static_cast<std::uint32_t>(result.rows.size()));
  }
  return result;
}

namespace {

std::vector<std::uint32_t> words(std::span<const std::int32_t> values) {
  return {values.begin(), values.end()};
}

// Mesa's llvmpipe (22.3) takes time with the square of a draw's triangles, and goes through loops
// but once in a vertex shader's last lanes where they are no whole group.
constexpr std::uint32_t kSoftwarePatches = 32;

std::vector<Model::Run> shown_patches(const PolygonMesh& mesh, bool is_software) {
  const std::int32_t most =
      is_software ? std::int32_t{kSoftwarePatches} : std::numeric_limits<std::int32_t>::max();
  std::vector<std::int32_t> holes = mesh.hole_faces;
  std::ranges::sort(holes);
  holes.push_back(mesh.face_count());
  std::vector<Model::Run> runs;
  std::int32_t face = 0;
  for (const std::int32_t hole : holes) {
    if (hole > face) {
      std::int32_t first = mesh.face_offsets[face];
      const std::int32_t end = mesh.face_offsets[hole];
      for (std::int32_t count = 0; first < end; first += count) {
        count = std::min(most, end - first);
        const auto start = static_cast<std::uint32_t>(first),
                   corners = static_cast<std::uint32_t>(count);
        runs.push_back({start, is_software ? kSoftwarePatches : corners, start + corners});
      }
    }
    face = hole + 1;
  }
  return runs;
}

}  // namespace

Model::Model(const Device& device, vulkan::Context& context, const Scene& scene)
    : system_(scene.mesh, scene.system),
      tables_(context, system_, {shared::kVertexFloats * sizeof(float), device.has_tessellation()}),
      indices_(device, tables_.index_count() * sizeof(std::uint32_t),
               VK_BUFFER_USAGE_INDEX_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT, Place::Device),
      used_(word_buffer(device, words(system_.used_vertices()))),
      edges_(word_buffer(device, cage_edges(scene, system_.used_vertices()))),
      edge_count_(static_cast<std::uint32_t>(edges_.bytes() / (2 * sizeof(std::uint32_t)))),
      patches_(shown_patches(scene.mesh, device.is_software())),
      face_count_(static_cast<std::uint32_t>(scene.mesh.face_count())) {
  const NearestGiven nearest = nearest_given(system_);
  offsets_ = word_buffer(device, nearest.offsets);
  nearest_ = word_buffer(device, nearest.rows);
  if (const std::vector<glm::vec2> uvs = system_.uvs(); !uvs.empty())
    uvs_ = buffer_of(device, std::as_bytes(std::span(uvs)), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
  const Buffer staging(device, tables_.upload_bytes(), VK_BUFFER_USAGE_TRANSFER_SRC_BIT,
                       Place::Host);
  tables_.write_upload(system_, staging.mapped());
  device.run([&](VkCommandBuffer commands) {
    tables_.record_upload(commands, staging, 0, {indices_, 0});
    barrier(commands, vulkan::kExitScope,
            {VK_PIPELINE_STAGE_VERTEX_INPUT_BIT, VK_ACCESS_INDEX_READ_BIT});
  });
}

namespace {

OwnedDescriptorPool make_pool(VkDevice device) {
  const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                                  shared::kBindingCount + shared::kSurfaceBindingCount};
  VkDescriptorPoolCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
  info.maxSets = 2;
  info.poolSizeCount = 1;
  info.pPoolSizes = &size;
  return OwnedDescriptorPool(device, info, "vkCreateDescriptorPool");
}

// planish cuts what is beyond the limit; the viewer binds its vertices whole.
std::uint64_t vertex_bytes(vulkan::Context& context, const Model& model) {
  const std::uint64_t bytes =
      std::uint64_t(model.system().vertex_count()) * shared::kVertexFloats * sizeof(float);
  context.binding_limit().require(bytes, formatted("vertices of level {}", model.system().level()),
                                  "choose a lower level");
  return bytes;
}

}  // namespace

Frame::Frame(const Device& device, vulkan::Context& context, const Model& model)
    : points_(device, model.system().given_count() * sizeof(glm::vec3),
              VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, Place::Host),
      vertices_(device, vertex_bytes(context, model),
                VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_VERTEX_BUFFER_BIT |
                    VK_BUFFER_USAGE_TRANSFER_SRC_BIT,
                Place::Device),
      status_(device, sizeof(vulkan::GpuStatus), VK_BUFFER_USAGE_TRANSFER_DST_BIT, Place::Host),
      pool_(make_pool(device)) {}

vulkan::FrameSlot Frame::slot() const {
  constexpr std::uint32_t kFloat = sizeof(float);
  return {
      .given = {points_, 0, sizeof(glm::vec3)},
      .vertices = {vertices_, 0, shared::kVertexFloats * kFloat, 0, shared::kNormalFloat * kFloat}};
}

void Frame::bind(VkDevice device, const Model& model, const Pipelines& pipelines,
                 const vulkan::Solve& solve) {
  // In the order of the bindings in shared.h.
  const std::array<VkBuffer, shared::kBindingCount> buffers{
      points_,       solve.control_points(), vertices_,      model.used(),
      model.edges(), model.offsets(),        model.nearest()};
  std::array<VkDescriptorBufferInfo, shared::kBindingCount> infos{};
  for (std::size_t i = 0; i < buffers.size(); ++i) infos[i] = {buffers[i], 0, VK_WHOLE_SIZE};
  set_ = make_set(device, pool_, pipelines.set_layout, infos);
  if (!pipelines.patches) return;
  const vulkan::SurfaceBuffers surface = vulkan::surface_buffers(model.tables(), solve);
  surface_set_ = make_set(
      device, pool_, pipelines.surface_layout,
      std::array{surface.words, surface.links, surface.state, surface.given, surface.weights});
}

std::span<glm::vec3> Frame::points() const {
  const auto bytes = points_.mapped();
  return {reinterpret_cast<glm::vec3*>(bytes.data()), bytes.size() / sizeof(glm::vec3)};
}

vulkan::GpuStatus Frame::status() const {
  vulkan::GpuStatus status;
  std::memcpy(&status, status_.mapped().data(), sizeof status);
  return status;
}

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
