#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "edit_session.h"
#include "overlay.h"
#include "renderer.h"
#include "targets.h"

namespace planish::viewer {

inline constexpr double kFramesPerSecond = 60;  // of the animation, off-screen

struct HeadlessOptions {
  VkExtent2D extent{800, 600};
  OrbitCamera camera;
  ViewSettings settings;
};

/// As the surface's vertices stand in their buffer.
struct SurfaceVertex {
  glm::vec3 position, normal;
  float error;
};
static_assert(sizeof(SurfaceVertex) == shared::kVertexFloats * sizeof(float));

/// The frame loop without a window.
class Headless {
 public:
  Headless(const Device& device, Scene scene, const HeadlessOptions& options);

  /// Renders the next frames of the animation, each 1 / kFramesPerSecond after the one before, the
  /// first at rest; then waits for them.
  void run(int frames);

  /// A frame of a session's points, with what is selected; then waits for it.
  enum class Solved {
    On,   ///< from what the last frames found, as settings say
    Anew  ///< to the end: the same points give the same bits
  };
  void show(const EditSession& session, Solved solved);

  [[nodiscard]] const HeadlessOptions& options() const { return options_; }
  /// Of the last frame.
  [[nodiscard]] vulkan::GpuStatus status() const { return *renderer_.status(); }
  [[nodiscard]] const vulkan::System& system() const { return renderer_.system(); }
  [[nodiscard]] const Scene& scene() const { return renderer_.scene(); }
  [[nodiscard]] std::vector<SurfaceVertex> vertices() const;
  /// RGB, top row first, with a legend where the settings show errors.
  [[nodiscard]] std::vector<std::uint8_t> picture();

 private:
  void draw(VkCommandBuffer commands);

  const Device& device_;
  HeadlessOptions options_;
  OwnedRenderPass pass_;
  Image image_;
  Targets targets_;
  Overlay overlay_;
  Renderer renderer_;
  int next_frame_ = 0;
  const EditSession* shown_ = nullptr;  // in the last frame
  int revision_ = 0;                    // of its rules
};

}  // namespace planish::viewer
