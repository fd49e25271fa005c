#include "headless.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include "edit_overlay.h"
#include "legend.h"

namespace planish::viewer {
namespace {

constexpr float kFontHeight = 600;  // of the picture for which ImGui's font has its own size

int font_scale(VkExtent2D extent) {
  return std::max(1,
                  static_cast<int>(std::lround(static_cast<float>(extent.height) / kFontHeight)));
}

}  // namespace

Headless::Headless(const Device& device, Scene scene, const HeadlessOptions& options)
    : device_(device),
      options_(options),
      pass_(make_render_pass(device, {kPictureFormat, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL})),
      image_(device, {kPictureFormat, options.extent, VK_SAMPLE_COUNT_1_BIT,
                      VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                      VK_IMAGE_ASPECT_COLOR_BIT}),
      targets_(device, pass_, kPictureFormat, options.extent, std::array{image_.view()}),
      overlay_(device, pass_, font_scale(options.extent)),
      renderer_(device, pass_, std::move(scene)) {
  if (options.settings.tessellate) device.demand_tessellation();
}

void Headless::draw(VkCommandBuffer commands) {
  overlay_.begin(options_.extent);
  if (options_.settings.heat && renderer_.status())
    draw_legend("largest " +
                error_text(renderer_.status()->residual / renderer_.system().diagonal()) +
                " after " + solve_text(scene().system.method, renderer_.status()->iterations));
  if (shown_)
    draw_selection(*shown_, options_.camera, {options_.extent.width, options_.extent.height});
  targets_.begin(commands, 0);
  renderer_.draw(commands, options_.camera, options_.extent, options_.settings);
  overlay_.record(commands);
  vkCmdEndRenderPass(commands);
}

void Headless::run(int frames) {
  for (int i = 0; i < frames; ++i) {
    renderer_.prepare(options_.settings.level);
    draw(renderer_.begin_frame(next_frame_++ / kFramesPerSecond, options_.settings));
    renderer_.end_frame();
  }
  renderer_.finish();
}

void Headless::show(const EditSession& session, Solved solved) {
  shown_ = &session;
  if (session.revision() != revision_) {
    renderer_.set_mesh(session.rest());
    revision_ = session.revision();
  }
  ViewSettings settings = options_.settings;
  if (solved == Solved::Anew) {
    settings.warm_start = false;
    settings.iterations = kMostIterations;
  }
  renderer_.prepare(settings.level);
  draw(renderer_.begin_frame(session.points(), settings));
  renderer_.end_frame();
  renderer_.finish();
}

std::vector<std::uint8_t> Headless::picture() {
  const Buffer copy = picture_buffer(device_, options_.extent);
  // Once more, now that the status of the last frame is known.
  const VkCommandBuffer commands = renderer_.begin_redraw();
  draw(commands);
  copy_picture(commands, image_, options_.extent, copy);
  renderer_.end_frame();
  renderer_.finish();
  return rgb_of(copy);
}

std::vector<SurfaceVertex> Headless::vertices() const {
  std::vector<SurfaceVertex> result(renderer_.system().vertex_count());
  const std::size_t bytes = result.size() * sizeof(SurfaceVertex);
  const Buffer copy(device_, bytes, VK_BUFFER_USAGE_TRANSFER_DST_BIT, Place::Host);
  device_.run([&](VkCommandBuffer commands) {
    const VkBufferCopy region{0, 0, bytes};
    vkCmdCopyBuffer(commands, renderer_.vertices(), copy, 1, &region);
    host_barrier(commands);
  });
  std::memcpy(result.data(), copy.mapped().data(), bytes);
  return result;
}

}  // namespace planish::viewer
