#include "frames.h"

#include <planish/vulkan/embed.h>

#include <cstring>
#include <glm/gtc/matrix_access.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <optional>
#include <utility>

#include "frame_objects.h"
#include "patches_frag.h"
#include "patches_tesc.h"
#include "patches_tese.h"
#include "patches_vert.h"
#include "scene_frag.h"
#include "scene_vert.h"
#include "shadow_vert.h"
#include "skin_comp.h"

namespace pv = planish::vulkan;

namespace {

constexpr std::uint32_t kInFlight = 2;
constexpr std::uint32_t kSide = kImageSide;
constexpr VkDeviceSize kPixels = VkDeviceSize{kSide} * kSide;
constexpr VkFormat kColour = VK_FORMAT_R8G8B8A8_UNORM, kNumbers = VK_FORMAT_R32G32B32A32_SFLOAT;
// Positions of snorm16, 8 bytes; a normal of 4 and a tangent of 16.
constexpr std::uint32_t kPositionBytes = 8, kAttributeBytes = 20;

struct Bones {
  glm::vec4 rows[6];
  std::uint32_t count;
};
struct View {
  glm::mat4 clip_from_world;
  std::uint32_t face_count, corner_count, is_software;
  float edges;
};
struct Camera {
  glm::mat4 clip_from_world;
  glm::vec4 box_center, box_half;
};

// What a frame in flight has for itself.
struct Frame {
  MappedBuffer points, positions, attributes, images;
  VkCommandBuffer commands;
  VkFence fence;
  std::optional<int> number;  // in flight, or done and not looked at
};

class Renderer {
 public:
  Renderer(Application& app, const planish::PolygonMesh& mesh, float half)
      : app_(app),
        objects_(app),
        system_(mesh, {.level = 3, .textured = true}),
        context_(
            pv::HostDevice{app.get_instance_proc, app.instance, app.physical_device, app.device}),
        tables_(context_, system_, {.answers_places = true}),
        half_(half) {
    make_buffers(mesh);
    make_solve();
    skin_ = objects_.make_kernel(
        skin_comp, sizeof(Bones),
        {{rest_.handle, frames_[0].points.handle}, {rest_.handle, frames_[1].points.handle}});
    // Shadows, and depth before colours, read positions alone.
    shadow_ = objects_.make_pass(kSide, {}, {shadow_vert}, {kPositionBytes},
                                 {{0, VK_FORMAT_R16G16B16A16_SNORM, 0}}, sizeof(Camera));
    scene_ = objects_.make_pass(kSide, {kColour, kNumbers, kNumbers}, {scene_vert, scene_frag},
                                {kPositionBytes, kPositionBytes, kAttributeBytes, 8},
                                {{0, VK_FORMAT_R16G16B16A16_SNORM, 0},
                                 {1, VK_FORMAT_R16G16B16A16_SNORM, 0},
                                 {2, VK_FORMAT_R16G16_SNORM, 0},
                                 {2, VK_FORMAT_R32G32B32A32_SFLOAT, 4},
                                 {3, VK_FORMAT_R32G32_SFLOAT, 0}},
                                sizeof(Camera));
    if (!app.has_tessellation) return;
    surface_ = pv::surface_buffers(tables_, *solve_);
    patches_ = objects_.make_pass(
        kSide, {kColour}, {patches_vert, patches_frag, patches_tesc, patches_tese}, {}, {},
        sizeof(View),
        {surface_.words, surface_.links, surface_.state, surface_.given, surface_.weights});
  }

  // Waits for the frame that the slot's buffers were last used by, and for no other.
  std::optional<int> wait(std::uint32_t slot, DrawnFrame& drawn) {
    Frame& frame = frames_[slot];
    if (!frame.number) return {};
    check(LOAD(app_, vkWaitForFences)(app_.device, 1, &frame.fence, VK_TRUE, ~std::uint64_t{0}),
          "vkWaitForFences");
    check(LOAD(app_, vkResetFences)(app_.device, 1, &frame.fence), "vkResetFences");
    const std::byte* from = frame.images.bytes.data();
    const auto take = [&](auto& to) {
      to.resize(kPixels);
      std::memcpy(to.data(), from, kPixels * sizeof to[0]);
      from += kPixels * sizeof to[0];
    };
    take(drawn.colours);
    take(drawn.motions);
    take(drawn.textures);
    take(drawn.shadow);
    if (app_.has_tessellation) take(drawn.patches);
    return std::exchange(frame.number, {});
  }

  void draw(int number, const std::array<glm::mat4x3, 2>& bones, const glm::mat4& view) {
    Frame& frame = frames_[number % kInFlight];
    VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    check(LOAD(app_, vkBeginCommandBuffer)(frame.commands, &begin), "vkBeginCommandBuffer");
    record(number, bones, view);
    check(LOAD(app_, vkEndCommandBuffer)(frame.commands), "vkEndCommandBuffer");
    VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &frame.commands;
    check(LOAD(app_, vkQueueSubmit)(app_.queue, 1, &submit, frame.fence), "vkQueueSubmit");
    frame.number = number;
  }

 private:
  void make_buffers(const planish::PolygonMesh& mesh) {
    constexpr auto kStorage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
    constexpr auto kVertices = VK_BUFFER_USAGE_VERTEX_BUFFER_BIT;
    const auto vertex_count = static_cast<VkDeviceSize>(tables_.vertex_count());
    rest_ = app_.make_buffer(12 * mesh.positions.size(), kStorage);
    const std::vector<glm::vec3> rest(mesh.positions.begin(), mesh.positions.end());
    std::memcpy(rest_.bytes.data(), rest.data(), rest_.bytes.size());
    // Texture coordinates stay as they are: a stream of the application's own.
    uvs_ = app_.make_buffer(8 * vertex_count, kVertices);
    std::memcpy(uvs_.bytes.data(), system_.uvs().data(), uvs_.bytes.size());
    indices_ = app_.make_buffer(4 * tables_.index_count(), VK_BUFFER_USAGE_INDEX_BUFFER_BIT |
                                                               VK_BUFFER_USAGE_TRANSFER_DST_BIT);
    for (Frame& frame : frames_) {
      frame.points = app_.make_buffer(rest_.bytes.size(), kStorage);
      frame.positions = app_.make_buffer(kPositionBytes * vertex_count, kStorage | kVertices);
      frame.attributes = app_.make_buffer(kAttributeBytes * vertex_count, kStorage | kVertices);
      frame.images = app_.make_buffer(44 * kPixels, VK_BUFFER_USAGE_TRANSFER_DST_BIT);
      frame.commands = objects_.make_commands();
      frame.fence = objects_.make_fence();
    }
  }

  void make_solve() {
    const auto slot_of = [&](const Frame& frame) {
      pv::FrameSlot slot;
      slot.given = {frame.points.handle};
      slot.vertices = {.buffer = frame.positions.handle,
                       .stride = kPositionBytes,
                       .normal_offset = 0,
                       .position_format = pv::VertexFormat::Snorm16x4,
                       .normal_format = pv::VertexFormat::Octahedral16,
                       .attributes = {frame.attributes.handle, 0, kAttributeBytes},
                       .box_half = {half_, half_, half_},
                       .tangent_offset = 4};
      return slot;
    };
    const pv::FrameSlot first = slot_of(frames_[0]);
    solve_.emplace(context_, tables_,
                   pv::SolveOptions{.given = first.given,
                                    .vertices = first.vertices,
                                    .further_slots = {slot_of(frames_[1])}});
    MappedBuffer staging =
        app_.make_buffer(tables_.upload_bytes(), VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
    tables_.write_upload(system_, staging.bytes);
    app_.run([&](VkCommandBuffer commands) {
      tables_.record_upload(commands, staging.handle, 0, {indices_.handle, 0});
    });
  }

  void barrier(VkCommandBuffer commands, VkPipelineStageFlags from, VkAccessFlags writes,
               VkPipelineStageFlags to, VkAccessFlags reads) {
    VkMemoryBarrier memory{VK_STRUCTURE_TYPE_MEMORY_BARRIER};
    memory.srcAccessMask = writes;
    memory.dstAccessMask = reads;
    LOAD(app_, vkCmdPipelineBarrier)
    (commands, from, to, 0, 1, &memory, 0, nullptr, 0, nullptr);
  }

  void record(int number, const std::array<glm::mat4x3, 2>& bones, const glm::mat4& view) {
    const std::uint32_t slot = number % kInFlight;
    const Frame &frame = frames_[slot], &last = frames_[(number + 1) % kInFlight];
    const VkCommandBuffer commands = frame.commands;
    skin(commands, slot, bones);
    // Before planish: the points are there, and the draws that read this slot's vertices, the last
    // frame's motion vectors among them, have read them, as its patches the control points.
    barrier(
        commands,
        VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_VERTEX_INPUT_BIT | patch_stages(),
        VK_ACCESS_SHADER_WRITE_BIT, pv::kEntryScope.stages, pv::kEntryScope.accesses);
    solve_->record_solve(commands,
                         {.iterations = system_.sufficient_iterations(system_.rest_error()),
                          .stop_error = static_cast<float>(system_.tolerance()),
                          .warm_start = number > 0,
                          .slot = slot});
    solve_->record_evaluate(commands, {slot});
    barrier(
        commands, pv::kExitScope.stages, pv::kExitScope.accesses,
        VK_PIPELINE_STAGE_VERTEX_INPUT_BIT | patch_stages(),
        VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT | VK_ACCESS_INDEX_READ_BIT | VK_ACCESS_SHADER_READ_BIT);
    // At a slant, without perspective, from where z is least.
    glm::mat4 clip(1.0f);
    clip = glm::scale(clip, glm::vec3(1, 1, 0.5f) / (1.2f * half_));
    clip[3][2] = 0.5f;
    clip *= view;
    const Camera camera{clip, glm::vec4(0), glm::vec4(half_)};
    // The first frame has no last one.
    const MappedBuffer& before = number > 0 ? last.positions : frame.positions;
    const auto draw_triangles = [&] {
      LOAD(app_, vkCmdDrawIndexed)(commands, tables_.index_count(), 1, 0, 0, 0);
    };
    draw_pass(commands, shadow_, camera, {frame.positions.handle}, draw_triangles);
    draw_pass(commands, scene_, camera,
              {frame.positions.handle, before.handle, frame.attributes.handle, uvs_.handle},
              draw_triangles);
    if (app_.has_tessellation)
      draw_pass(commands, patches_,
                View{clip, surface_.face_count, surface_.corner_count, app_.is_software,
                     kSide / 2 / 6.0f},
                {}, [&] {
                  // Mesa's llvmpipe (22.3) goes through loops but once in a draw's last lanes where
                  // they are no whole group: what is beyond the last corner is not drawn.
                  const std::uint32_t group = app_.is_software ? 32 : 1;
                  const std::uint32_t count = (surface_.corner_count + group - 1) / group * group;
                  LOAD(app_, vkCmdDraw)(commands, count, 1, 0, 0);
                });
    fetch(commands, frame);
  }

  void skin(VkCommandBuffer commands, std::uint32_t slot, const std::array<glm::mat4x3, 2>& bones) {
    Bones parameters;
    for (int bone = 0; bone < 2; ++bone)
      for (int row = 0; row < 3; ++row)
        parameters.rows[3 * bone + row] = glm::row(bones[bone], row);
    parameters.count = static_cast<std::uint32_t>(tables_.given_count());
    // The solve of this slot's last frame has read the points: its fence was waited for.
    LOAD(app_, vkCmdBindPipeline)(commands, VK_PIPELINE_BIND_POINT_COMPUTE, skin_.pipeline);
    LOAD(app_, vkCmdBindDescriptorSets)
    (commands, VK_PIPELINE_BIND_POINT_COMPUTE, skin_.layout, 0, 1, &skin_.sets[slot], 0, nullptr);
    LOAD(app_, vkCmdPushConstants)
    (commands, skin_.layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof parameters, &parameters);
    LOAD(app_, vkCmdDispatch)(commands, (parameters.count + 63) / 64, 1, 1);
  }

  [[nodiscard]] VkPipelineStageFlags patch_stages() const {
    return app_.has_tessellation ? VK_PIPELINE_STAGE_VERTEX_SHADER_BIT |
                                       VK_PIPELINE_STAGE_TESSELLATION_EVALUATION_SHADER_BIT
                                 : 0;
  }

  template <class Parameters, class Draw>
  void draw_pass(VkCommandBuffer commands, const Pass& pass, const Parameters& parameters,
                 const std::vector<VkBuffer>& vertices, const Draw& draw) {
    std::vector<VkClearValue> clears(pass.images.size());
    clears.back().depthStencil = {1, 0};
    VkRenderPassBeginInfo begin{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
    begin.renderPass = pass.pass;
    begin.framebuffer = pass.framebuffer;
    begin.renderArea = {{0, 0}, {kSide, kSide}};
    begin.clearValueCount = static_cast<std::uint32_t>(clears.size());
    begin.pClearValues = clears.data();
    LOAD(app_, vkCmdBeginRenderPass)(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
    LOAD(app_, vkCmdBindPipeline)(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pass.pipeline);
    LOAD(app_, vkCmdPushConstants)
    (commands, pass.layout, pass.parameter_stages, 0, sizeof parameters, &parameters);
    if (pass.set) LOAD(app_, vkCmdBindDescriptorSets)
    (commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pass.layout, 0, 1, &pass.set, 0, nullptr);
    const std::vector<VkDeviceSize> offsets(vertices.size(), 0);
    if (!vertices.empty()) LOAD(app_, vkCmdBindVertexBuffers)
    (commands, 0, static_cast<std::uint32_t>(vertices.size()), vertices.data(), offsets.data());
    LOAD(app_, vkCmdBindIndexBuffer)(commands, indices_.handle, 0, VK_INDEX_TYPE_UINT32);
    draw();
    LOAD(app_, vkCmdEndRenderPass)(commands);
  }

  // The images to memory that the host reads once the frame is done.
  void fetch(VkCommandBuffer commands, const Frame& frame) {
    VkDeviceSize offset = 0;
    const auto copy = [&](const Pass& pass, std::size_t i) {
      const bool is_depth = pass.formats[i] == VK_FORMAT_D32_SFLOAT;
      VkBufferImageCopy region{};
      region.bufferOffset = offset;
      region.imageSubresource = {is_depth ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT,
                                 0, 0, 1};
      region.imageExtent = {kSide, kSide, 1};
      LOAD(app_, vkCmdCopyImageToBuffer)
      (commands, pass.images[i], VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, frame.images.handle, 1,
       &region);
      offset += kPixels * (pass.formats[i] == kNumbers ? 16 : 4);
    };
    for (std::size_t i = 0; i < 3; ++i) copy(scene_, i);
    copy(shadow_, 0);
    if (app_.has_tessellation) copy(patches_, 0);
    barrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
            VK_PIPELINE_STAGE_HOST_BIT, VK_ACCESS_HOST_READ_BIT);
  }

  Application& app_;
  FrameObjects objects_;
  pv::System system_;
  pv::Context context_;
  pv::DeviceSystem tables_;
  float half_;
  MappedBuffer rest_, uvs_, indices_;
  std::array<Frame, kInFlight> frames_;
  std::optional<pv::Solve> solve_;
  Kernel skin_;
  Pass shadow_, scene_, patches_;
  pv::SurfaceBuffers surface_{};
};

}  // namespace

void render_frames(Application& app, const planish::PolygonMesh& mesh, float half, int frame_count,
                   const std::function<std::array<glm::mat4x3, 2>(int)>& pose,
                   const std::function<glm::mat4(int)>& view,
                   const std::function<void(int, const DrawnFrame&)>& drawn) {
  Renderer renderer(app, mesh, half);
  DrawnFrame images;
  for (int frame = 0; frame < frame_count + int(kInFlight); ++frame) {
    if (const auto done = renderer.wait(frame % kInFlight, images)) drawn(*done, images);
    if (frame < frame_count) renderer.draw(frame, pose(frame), view(frame));
  }
}
