#pragma once

#include <optional>

#include "device.h"

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

}  // namespace planish::viewer
