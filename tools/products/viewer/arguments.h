#pragma once

#include <optional>
#include <string>

#include "scene.h"

namespace planish::viewer {

/// What was asked for on the command line.
struct Arguments {
  std::string scene = "scenes/goblet.json", job, device, png, script;
  std::string save;  ///< prefix of what Ctrl+S writes; empty: NAME_edited
  bool headless = false, validate = false, edit = false;
  std::optional<int> level;  ///< empty: the scene's
  int frames = 0;            ///< 0: off-screen one, in a window until it is closed
  int instances = 0;         ///< 0: the animated mesh itself
  int width = 1280, height = 720;
  float azimuth_degrees = 35, elevation_degrees = 20;
  ViewSettings settings;
};

/// Empty where help or version was asked for, which it has printed. Throws Error{InvalidArgument}.
[[nodiscard]] std::optional<Arguments> parse_arguments(int argc, const char* const* argv);

}  // namespace planish::viewer
