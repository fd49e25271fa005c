#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <optional>
#include <string>

#include "device.h"
#include "edit_session.h"
#include "planish/fair/fair_net.h"
#include "renderer.h"
#include "scene.h"

namespace planish::viewer {

/// Dear ImGui in the viewer's render pass: it draws what is asked for between begin() and record().
/// One at a time in a process.
class Overlay {
 public:
  /// `scale` multiplies ImGui's font of 13 pixels. `pass` is of make_render_pass().
  Overlay(const Device& device, VkRenderPass pass, int scale);
  ~Overlay();
  Overlay(const Overlay&) = delete;
  Overlay& operator=(const Overlay&) = delete;

  /// Off-screen the picture's extent is given; a window's backend has told ImGui its own.
  void begin(const std::optional<VkExtent2D>& off_screen = std::nullopt);
  /// Inside the render pass. Buffers of two frames are kept.
  void record(VkCommandBuffer commands);

 private:
  /// ImGui's global state; nothing else of it outlives this.
  struct ImguiContext {
    ImguiContext();
    ~ImguiContext();
  };
  const Device& device_;
  ImguiContext context_;
  OwnedDescriptorPool pool_;
};

/// Draws the scale of the error colours, with a number at each decade and a line of text below, in
/// the lower left corner; between Overlay::begin() and record().
void draw_legend(const std::string& line);

/// "1.2e-05", the text of an error relative to the diagonal.
[[nodiscard]] std::string error_text(double relative_error);

/// "1 iteration", "2 iterations"; "the fair method", which has none.
[[nodiscard]] std::string solve_text(InterpolationMethod method, std::uint32_t iterations);

/// The selected vertices as discs and those that move along as dots, the larger the more they do.
/// Between Overlay::begin() and record().
void draw_selection(const EditSession& session, const OrbitCamera& camera, const glm::vec2& size);

/// What the panel tells beside the settings.
struct PanelFacts {
  std::string device;
  std::string problem;  ///< of the last change; empty if it worked
  float frames_per_second = 0;
  bool tessellates = false;  ///< the device
};

/// What was clicked there.
struct EditClicks {
  bool undoes = false, redoes = false, saves = false;
};

/// Sliders, toggles and numbers; changes `settings`. Between Overlay::begin() and record().
/// `edits` is whether points are moved; `session` is null until that was so once.
EditClicks draw_panel(const Renderer& renderer, const PanelFacts& facts, ViewSettings& settings,
                      EditSession* session, bool& edits);

}  // namespace planish::viewer
