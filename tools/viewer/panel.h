#pragma once

#include <string>

#include "renderer.h"

namespace planish::viewer {

/// What the panel tells beside the settings.
struct PanelFacts {
  std::string device;
  std::string problem;  ///< of the last change; empty if it worked
  float frames_per_second = 0;
};

/// Sliders, toggles and numbers; changes `settings`. Between Overlay::begin() and record().
void draw_panel(const Renderer& renderer, const PanelFacts& facts, ViewSettings& settings);

}  // namespace planish::viewer
