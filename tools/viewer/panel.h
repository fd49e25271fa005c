#pragma once

#include <string>

#include "edit_session.h"
#include "renderer.h"

namespace planish::viewer {

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
