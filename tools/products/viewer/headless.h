#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "device.h"
#include "edit_session.h"
#include "overlay.h"
#include "renderer.h"

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

namespace planish::viewer {
namespace steps {

struct Pick {
  glm::vec2 pixel;
  bool adds = false;
};
struct Select {
  std::vector<std::int32_t> vertices;
};
struct Radius {
  double length = 0;
};
struct Move {
  glm::dvec3 way{};
  int frames = 1;
};
struct Drag {
  glm::vec2 from, to;
  int frames = 1;
};
struct Crease {
  std::int32_t v0 = 0, v1 = 0;
};
struct CreaseAt {
  glm::vec2 pixel;
};
struct Corner {
  std::int32_t vertex = 0;
};
struct Undo {
  int count = 1;
};
struct Redo {
  int count = 1;
};
struct Frames {
  int count = 1;
};
struct Picture {
  std::string path;
};
struct Save {
  SavedPart part = SavedPart::Mesh;
  std::string path;
};

}  // namespace steps

}  // namespace planish::viewer

namespace planish::viewer {

/// One line of a script.
struct ScriptStep {
  std::string where;  ///< file and line
  std::variant<steps::Pick, steps::Select, steps::Radius, steps::Move, steps::Drag, steps::Crease,
               steps::CreaseAt, steps::Corner, steps::Undo, steps::Redo, steps::Frames,
               steps::Picture, steps::Save>
      what;
};

/// The steps of a script: one a line; what follows # is left out. `name` stands in messages. Throws
/// Error{InvalidArgument}: `name:line: what is wanted, what stands there`.
[[nodiscard]] std::vector<ScriptStep> parse_script(std::string_view text, const std::string& name);
/// The same of a file. Throws Error{UnreadableInput}, too.
[[nodiscard]] std::vector<ScriptStep> read_script(const std::string& path);

/// Drives a session as the mouse and the keys of a window do, and draws each frame. Returns how
/// many it drew. Throws Error with the step's file and line.
int run_script(std::span<const ScriptStep> script, EditSession& session, Headless& headless,
               const SaveOptions& save);

}  // namespace planish::viewer
