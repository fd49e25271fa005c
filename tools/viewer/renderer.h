#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>

#include "animation.h"
#include "camera.h"
#include "frame.h"
#include "view_settings.h"

namespace planish::viewer {

/// How a frame is submitted in a window: after the image is there, before it is presented.
struct FrameSemaphores {
  VkSemaphore image_ready = VK_NULL_HANDLE, drawn = VK_NULL_HANDLE;
};

/// The frame loop's work: solve, evaluate and draw in one command buffer, two frames in flight.
///
///   prepare(level);                              // waits for the frame before last
///   commands = begin_frame(seconds, settings);
///   begin a render pass; draw(commands, ...); more draws; end it
///   end_frame(semaphores);                       // submits
class Renderer {
 public:
  /// `pass` is of make_render_pass(); it and `device` outlive the Renderer.
  Renderer(const Device& device, VkRenderPass pass, Scene scene);
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  /// From the next prepare() on the scene has that mesh, of as many vertices: other tags, which are
  /// other rules.
  void set_mesh(PolygonMesh mesh);
  /// Waits for the frame before last, so that what it waited for and signalled may be used again,
  /// and builds another level, once all frames are done. Throws what Model and Frame throw; then
  /// the old level remains.
  void prepare(int level);
  /// Writes the points of that time and records what planish does with them, at the level that was
  /// prepared.
  VkCommandBuffer begin_frame(double seconds, const ViewSettings& settings);
  /// The same of points that somebody moves, one a vertex of the scene.
  VkCommandBuffer begin_frame(std::span<const glm::dvec3> points, const ViewSettings& settings);
  /// The same for drawing the last frame once more, once it is done.
  VkCommandBuffer begin_redraw();
  /// Inside the render pass: the surface and what else `settings` shows.
  void draw(VkCommandBuffer commands, const OrbitCamera& camera, VkExtent2D extent,
            const ViewSettings& settings) const;
  void end_frame(const FrameSemaphores& semaphores = {});

  /// Of the last frame that is known to be done; nothing before the first is.
  [[nodiscard]] const std::optional<vulkan::GpuStatus>& status() const { return status_; }
  /// Waits for all frames, so that status() is the last one's.
  void finish();

  [[nodiscard]] const Scene& scene() const { return scene_; }
  [[nodiscard]] const vulkan::System& system() const { return model_->system(); }
  /// The buffer that the last frame drew from; may be copied after finish().
  [[nodiscard]] VkBuffer vertices() const { return frames_[current_]->vertices(); }

 private:
  static constexpr std::size_t kFramesInFlight = 2;
  struct Slot {
    OwnedCommandPool pool;
    VkCommandBuffer commands = VK_NULL_HANDLE;
    OwnedFence done;
    bool submitted = false;
  };

  [[nodiscard]] Slot make_slot() const;
  void wait_for(std::size_t slot);
  VkCommandBuffer begin_commands();
  VkCommandBuffer begin_next();
  void build(int level);
  void record_surface(VkCommandBuffer commands, const ViewSettings& settings);
  [[nodiscard]] vulkan::Scope vertex_scope() const;  // where what planish makes is drawn
  void record_errors(VkCommandBuffer commands) const;

  const Device& device_;
  Scene scene_;
  Animation animation_;
  vulkan::Context context_;
  Pipelines pipelines_;
  std::unique_ptr<Model> model_;
  std::array<std::unique_ptr<Frame>, kFramesInFlight> frames_;
  std::unique_ptr<vulkan::Solve> solve_;  // of all frames
  bool is_warm_ = false;
  std::array<Slot, kFramesInFlight> slots_;
  std::size_t current_ = kFramesInFlight - 1;
  std::optional<vulkan::GpuStatus> status_;
  bool has_other_mesh_ = false;
};

}  // namespace planish::viewer
