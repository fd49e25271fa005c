#pragma once

#include <vulkan/vulkan.h>

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "device.h"
#include "planish/vulkan/embed.h"
#include "scene.h"
#include "shared.h"

namespace planish::viewer {

/// Pairs of the points that Solve::control_points() has, each edge of their mesh once: those of the
/// scene's mesh, of whose vertices `used` are rows, or with the fair method those of the mesh of
/// level 1.
[[nodiscard]] std::vector<std::uint32_t> cage_edges(const Scene& scene,
                                                    std::span<const std::int32_t> used);

// With prototypes, which planish's headers would leave out.

/// For each vertex of a System's surface the given points that fewest edges of the surface lead
/// to, as rows of System::used_vertices(): a given point's own limit point has that point alone,
/// the middle of a face all of its corners. Those of vertex i are rows[offsets[i]] to
/// rows[offsets[i + 1]].
struct NearestGiven {
  std::vector<std::uint32_t> offsets, rows;
};

[[nodiscard]] NearestGiven nearest_given(const vulkan::System& system);

// With prototypes, which planish's headers would leave out.

/// What all frames share: planish's tables of a scene at one level, the surface's indices, and what
/// the viewer draws and measures with. Read-only once made.
class Model {
 public:
  /// Uploads, and waits for it.
  Model(const Device& device, vulkan::Context& context, const Scene& scene);

  [[nodiscard]] const vulkan::System& system() const { return system_; }
  [[nodiscard]] const vulkan::DeviceSystem& tables() const { return tables_; }
  [[nodiscard]] VkBuffer indices() const { return indices_; }
  /// Of each vertex two floats; null where the mesh has no texture coordinates.
  [[nodiscard]] VkBuffer uvs() const { return uvs_; }
  [[nodiscard]] std::uint32_t edge_count() const { return edge_count_; }
  [[nodiscard]] std::uint32_t used_count() const {
    return static_cast<std::uint32_t>(system_.used_vertices().size());
  }

  /// Corners of the faces that are no holes, each a patch, by runs of their numbers. What a run
  /// counts beyond its end is not drawn.
  struct Run {
    std::uint32_t first, count, end;
  };
  [[nodiscard]] std::span<const Run> patches() const { return patches_; }
  [[nodiscard]] std::uint32_t face_count() const { return face_count_; }

  /// Bindings kUsedBinding to kNearestBinding of shared.h.
  [[nodiscard]] VkBuffer used() const { return used_; }
  [[nodiscard]] VkBuffer edges() const { return edges_; }
  [[nodiscard]] VkBuffer offsets() const { return offsets_; }
  [[nodiscard]] VkBuffer nearest() const { return nearest_; }

 private:
  vulkan::System system_;
  vulkan::DeviceSystem tables_;
  Buffer indices_, used_, edges_;
  std::uint32_t edge_count_;
  Buffer offsets_, nearest_, uvs_;
  std::vector<Run> patches_;
  std::uint32_t face_count_;
};

/// What one frame in flight of the animated shape has for itself, its slot of planish's Solve: the
/// given points, the vertices and the status.
class Frame {
 public:
  Frame(const Device& device, vulkan::Context& context, const Model& model);
  /// To be called once: what shaders read, with the control points of the Solve of all frames.
  void bind(VkDevice device, const Model& model, const Pipelines& pipelines,
            const vulkan::Solve& solve);

  /// To be written before the frame is submitted, once its last submission is done.
  [[nodiscard]] std::span<glm::vec3> points() const;
  /// Of the last solve, once its submission is done.
  [[nodiscard]] vulkan::GpuStatus status() const;

  [[nodiscard]] vulkan::FrameSlot slot() const;
  [[nodiscard]] VkBuffer vertices() const { return vertices_; }
  [[nodiscard]] VkBuffer status_target() const { return status_; }
  [[nodiscard]] VkDescriptorSet set() const { return set_; }
  /// Of the surface as shader code reads it.
  [[nodiscard]] VkDescriptorSet surface_set() const { return surface_set_; }

 private:
  Buffer points_, vertices_, status_;
  OwnedDescriptorPool pool_;
  VkDescriptorSet set_ = VK_NULL_HANDLE, surface_set_ = VK_NULL_HANDLE;
};

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
