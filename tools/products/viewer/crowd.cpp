#include "crowd.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <glm/ext/matrix_clip_space.hpp>
#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/packing.hpp>
#include <glm/trigonometric.hpp>
#include <span>
#include <string>
#include <utility>

#include "headless.h"
#include "planish/core/error.h"
#include "scene.h"

namespace planish::viewer {
namespace {

// In diagonals of the mesh: from an instance to the next, and where the eye is over the first row.
constexpr float kSpacing = 1.3f, kEyeHeight = 0.9f, kEyeBefore = 1.2f;
constexpr float kFieldDegrees = 40, kDownDegrees = 12;
constexpr float kFarRows = 1.5f;        // that there is room for before the far plane
constexpr std::uint32_t kRowShare = 2;  // as many rows as this times the columns
constexpr double kPhaseSeconds = 0.37;  // from an instance to the next
constexpr std::uint32_t kLeastPlaces = 16;
constexpr std::uint32_t kVertexBytes = shared::kCrowdFloats * sizeof(float);
constexpr VkFormat kMotionFormat = VK_FORMAT_R16G16B16A16_SFLOAT;
constexpr VkDeviceSize kMotionBytes = 8;

constexpr vulkan::Scope kDrawScope{
    VK_PIPELINE_STAGE_VERTEX_INPUT_BIT | VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT |
        VK_PIPELINE_STAGE_VERTEX_SHADER_BIT,
    VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT | VK_ACCESS_INDIRECT_COMMAND_READ_BIT |
        VK_ACCESS_SHADER_READ_BIT};

vulkan::SystemOptions with_levels(vulkan::SystemOptions options, std::vector<int> levels) {
  options.level = 0;
  options.levels = std::move(levels);
  return options;
}

std::uint32_t columns_of(std::uint32_t count) {
  return static_cast<std::uint32_t>(std::ceil(std::sqrt(double(count) / kRowShare)));
}

OwnedDescriptorPool make_crowd_pool(VkDevice device) {
  const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 2};
  VkDescriptorPoolCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
  info.maxSets = 1;
  info.poolSizeCount = 1;
  info.pPoolSizes = &size;
  return OwnedDescriptorPool(device, info, "vkCreateDescriptorPool");
}

}  // namespace

Crowd::Layer::Layer(const Device& device, VkFormat format, VkExtent2D extent)
    : pass(make_render_pass(device, {format, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL})),
      image(device, {format, extent, VK_SAMPLE_COUNT_1_BIT,
                     VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                     VK_IMAGE_ASPECT_COLOR_BIT}),
      targets(device, pass, format, extent, std::array{image.view()}) {}

Crowd::Crowd(const Device& device, Scene scene, const CrowdOptions& options)
    : device_(device),
      options_(options),
      colours_(device, kPictureFormat, options.extent),
      motions_(options.motions
                   ? std::optional<Layer>(std::in_place, device, kMotionFormat, options.extent)
                   : std::nullopt),
      context_(device.host()),
      pipelines_(device, colours_.pass),
      drawings_(device, colours_.pass, motions_ ? motions_->pass : VkRenderPass(VK_NULL_HANDLE),
                scene.system.textured),
      animation_(scene.mesh.positions),
      system_(scene.mesh, with_levels(scene.system, options.levels)),
      tables_(context_, system_, {kVertexBytes}),
      corner_count_(scene.mesh.face_vertices.size()),
      points_(device, point_bytes(), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, Place::Host),
      vertices_(device, tables_.tessellation_bytes(levels(), options.count),
                VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, Place::Device),
      uvs_(uvs()),
      before_(device, sizeof(glm::mat4), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, Place::Host),
      pool_(make_crowd_pool(device)),
      set_(make_set(device, pool_, drawings_.set_layout,
                    std::array<VkDescriptorBufferInfo, 2>{
                        {{vertices_, 0, VK_WHOLE_SIZE}, {before_, 0, VK_WHOLE_SIZE}}})),
      solve_(context_, tables_,
             {.max_iterations = kMostIterations, .given = {points_}, .instances = options.count}),
      levels_(context_, tables_, solve_, levels()) {
  const OrbitCamera around = camera_around(scene.mesh.positions);
  middle_ = around.centre;
  size_ = 2 * around.radius;
  const Buffer staging(device, tables_.upload_bytes(), VK_BUFFER_USAGE_TRANSFER_SRC_BIT,
                       Place::Host);
  tables_.write_upload(system_, staging.mapped());
  device.run([&](VkCommandBuffer commands) {
    tables_.record_upload(commands, staging, 0);
    solve_.record_reset(commands);
  });
}

VkDeviceSize Crowd::point_bytes() const {
  constexpr std::uint64_t kPointBytes = 16;  // of level 1, one a corner of the mesh
  const std::uint64_t corners = corner_count_;
  const auto coarsest = static_cast<std::uint64_t>(tables_.level_vertex_counts().front());
  const std::uint64_t each = std::max(corners * kPointBytes, coarsest * kVertexBytes);
  const std::uint64_t most = context_.max_storage_range() / each;
  if (options_.count > most)
    throw Error(ErrorCode::OutOfMemory,
                formatted("{} has room for {} instances of {} corners in one binding, not for {}; "
                          "choose fewer, or a smaller mesh",
                          device_.name(), most, corners, options_.count));
  return VkDeviceSize(options_.count) * system_.given_count() * sizeof(glm::vec3);
}

// Half as many of each finer level: what is far needs none of them, and there is more of it.
std::vector<std::uint32_t> Crowd::places() const {
  const std::vector<std::int32_t> counts = tables_.level_vertex_counts();
  std::vector<std::uint32_t> places;
  for (std::uint32_t k = 0; k < counts.size(); ++k) {
    const auto most = static_cast<std::uint32_t>(
        context_.max_storage_range() / (kVertexBytes * static_cast<std::uint64_t>(counts[k])));
    const std::uint32_t wanted = std::max(options_.count >> k, kLeastPlaces);
    places.push_back(std::clamp(wanted, 1u, std::max(1u, std::min(most, options_.count))));
  }
  return places;
}

vulkan::TessellationOptions Crowd::levels() const {
  vulkan::TessellationOptions options;
  options.vertices = {.buffer = vertices_,
                      .stride = kVertexBytes,
                      .normal_offset = shared::kNormalFloat * sizeof(float)};
  options.places = places();
  options.previous_positions = {vertices_, shared::kBeforeFloat * sizeof(float), kVertexBytes, 0};
  return options;
}

// Of an instance at each level, one after another; zeros where there are none.
Buffer Crowd::uvs() const {
  std::vector<glm::vec2> all;
  const std::vector<std::int32_t> counts = tables_.level_vertex_counts();
  for (std::size_t k = 0; k < counts.size(); ++k) {
    std::vector<glm::vec2> of_level = system_.uvs(options_.levels[k]);
    of_level.resize(static_cast<std::size_t>(counts[k]));
    all.insert(all.end(), of_level.begin(), of_level.end());
  }
  return buffer_of(device_, std::as_bytes(std::span(all)), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
}

// Rows one behind the other, the eye before the middle of the first.
glm::vec3 Crowd::offset_of(std::uint32_t instance) const {
  const std::uint32_t columns = columns_of(options_.count);
  const float aside =
      static_cast<float>(instance % columns) - 0.5f * static_cast<float>(columns - 1);
  return size_ * kSpacing * glm::vec3(aside, 0, -static_cast<float>(instance / columns));
}

void Crowd::look(double seconds) {
  const auto [width, height] = options_.extent;
  const float aspect = static_cast<float>(width) / static_cast<float>(height);
  const float rows = kRowShare * static_cast<float>(columns_of(options_.count)) + kFarRows;
  glm::mat4 projection = glm::perspectiveRH_ZO(glm::radians(kFieldDegrees), aspect, 0.1f * size_,
                                               size_ * (kEyeBefore + kSpacing * rows));
  projection[1][1] = -projection[1][1];
  const float ahead = options_.walk * static_cast<float>(seconds);
  view_.eye = middle_ + size_ * glm::vec3(0, kEyeHeight, kEyeBefore - ahead);
  const float down = glm::radians(kDownDegrees);
  const glm::vec3 forward(0, -std::sin(down), -std::cos(down));
  view_.clip_from_world =
      projection * glm::lookAtRH(view_.eye, view_.eye + forward, glm::vec3(0, 1, 0));
  view_.diagonal = size_;
  view_.key = glm::normalize(glm::vec3(-0.55f, 0.65f, 0.65f));
  view_.viewport = {width, height};
  view_.alpha = 1;
}

void Crowd::pose(double seconds) {
  const auto given = static_cast<std::size_t>(system_.given_count());
  const auto bytes = points_.mapped();
  const std::span all(reinterpret_cast<glm::vec3*>(bytes.data()), bytes.size() / sizeof(glm::vec3));
  for (std::uint32_t i = 0; i < options_.count; ++i) {
    const std::span<glm::vec3> own = all.subspan(i * given, given);
    animation_.pose(seconds + kPhaseSeconds * i, own);
    for (glm::vec3& p : own) p += offset_of(i);
  }
}

void Crowd::bind(VkCommandBuffer commands, VkPipelineLayout layout, VkPipeline pipeline) const {
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
  vkCmdPushConstants(commands, layout, push_stages(device_), 0, sizeof view_, &view_);
}

// A draw a level, whatever is seen.
void Crowd::draw(VkCommandBuffer commands, VkPipeline pipeline) const {
  bind(commands, drawings_.layout, pipeline);
  vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, drawings_.layout, 0, 1, &set_,
                          0, nullptr);
  vkCmdBindIndexBuffer(commands, levels_.indices(), 0, VK_INDEX_TYPE_UINT32);
  for (std::size_t k = 0; k < options_.levels.size(); ++k) {
    const vulkan::LevelDraw level = levels_.level_draw(k);
    const std::array<VkBuffer, 2> streams{uvs_, level.instances};
    const std::array<VkDeviceSize, 2> offsets{0, level.instances_offset};
    vkCmdBindVertexBuffers(commands, 0, streams.size(), streams.data(), offsets.data());
    vkCmdDrawIndexedIndirect(commands, level.draw, level.draw_offset, 1,
                             vulkan::Tessellation::kDrawStride);
  }
  vkCmdEndRenderPass(commands);
}

void Crowd::run(int frames) {
  for (int i = 0; i < frames; ++i, ++next_frame_) {
    const bool is_first = next_frame_ == 0;
    const double seconds = next_frame_ / kFramesPerSecond;
    pose(seconds);
    const glm::mat4 before = view_.clip_from_world;
    look(seconds);
    std::memcpy(before_.mapped().data(), is_first ? &view_.clip_from_world : &before,
                sizeof before);
    vulkan::TessellateParameters view;
    std::memcpy(view.clip_from_world.data(), &view_.clip_from_world, sizeof view.clip_from_world);
    view.viewport_height = static_cast<float>(options_.extent.height);
    view.chord_pixels = options_.chord_pixels;
    device_.run([&](VkCommandBuffer commands) {
      barrier(commands, kDrawScope, vulkan::kEntryScope);
      solve_.record_solve(commands, {.iterations = static_cast<std::uint32_t>(options_.iterations),
                                     .warm_start = true});
      if (is_first) levels_.record_reset(commands);
      levels_.record_evaluate(commands, view);
      barrier(commands, vulkan::kExitScope, kDrawScope);
      colours_.targets.begin(commands, 0);
      bind(commands, pipelines_.layout, pipelines_.background);
      vkCmdDraw(commands, 3, 1, 0, 0);
      draw(commands, drawings_.surface);
      if (!motions_) return;
      motions_->targets.begin(commands, 0);
      draw(commands, drawings_.motion);
    });
  }
}

CrowdFigures Crowd::figures() const {
  const Buffer words(device_, options_.count * sizeof(std::uint32_t),
                     VK_BUFFER_USAGE_TRANSFER_DST_BIT, Place::Host);
  const VkDeviceSize draw_bytes = options_.count * sizeof(VkDrawIndexedIndirectCommand);
  const Buffer draws(device_, draw_bytes, VK_BUFFER_USAGE_TRANSFER_DST_BIT, Place::Host);
  device_.run([&](VkCommandBuffer commands) {
    levels_.record_levels(commands, words, 0);
    const VkBufferCopy copy{0, 0, draw_bytes};
    vkCmdCopyBuffer(commands, levels_.draws(), draws, 1, &copy);
    host_barrier(commands);
  });
  CrowdFigures figures;
  figures.instances.resize(options_.levels.size());
  for (std::uint32_t i = 0; i < options_.count; ++i) {
    std::uint32_t level = 0;
    VkDrawIndexedIndirectCommand draw;
    std::memcpy(&level, &words.mapped()[i * sizeof level], sizeof level);
    std::memcpy(&draw, &draws.mapped()[i * sizeof draw], sizeof draw);
    ++(level == vulkan::Tessellation::kNotSeen ? figures.unseen : figures.instances[level]);
    figures.triangles += draw.indexCount / 3;
  }
  return figures;
}

std::vector<std::uint8_t> Crowd::picture() const {
  const Buffer copy = picture_buffer(device_, options_.extent);
  device_.run([&](VkCommandBuffer commands) {
    copy_picture(commands, colours_.image, options_.extent, copy);
  });
  return rgb_of(copy);
}

std::vector<glm::vec4> Crowd::motions() const {
  const auto [width, height] = options_.extent;
  const Buffer copy(device_, kMotionBytes * width * height, VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                    Place::Host);
  device_.run([&](VkCommandBuffer commands) {
    copy_picture(commands, motions_->image, options_.extent, copy);
  });
  std::vector<glm::vec4> pixels(std::size_t{width} * height);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    glm::uint64 halves = 0;
    std::memcpy(&halves, &copy.mapped()[i * kMotionBytes], kMotionBytes);
    pixels[i] = glm::unpackHalf4x16(halves);
  }
  return pixels;
}

}  // namespace planish::viewer
