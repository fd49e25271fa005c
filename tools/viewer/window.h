#pragma once

#include <functional>
#include <string>

#include "camera.h"
#include "instance.h"
#include "scene.h"
#include "view_settings.h"

struct GLFWwindow;

namespace planish::viewer {

struct WindowOptions {
  int width = 1280, height = 720;
  std::string device;  ///< as in DeviceOptions
  bool validation = false;
  std::function<void(std::string_view)> message;  ///< of the validation layer
  OrbitCamera camera;
  ViewSettings settings;
  bool edits = false;  ///< begins at rest, with points to drag
  std::string save;    ///< prefix of what is saved; empty: the scene's name and "_edited"
  int frames = 0;      ///< closes after so many; 0: when the user does
  /// Called before each frame with its number: where tests act as the user.
  std::function<void(GLFWwindow*, int)> before_frame;
};

/// What a window showed.
struct WindowRun {
  int frames = 0;
  double seconds = 0;
};

/// Shows the animation in a window until it is closed. Throws Error{NoDevice} where there is no
/// display, and what Device and Renderer throw.
WindowRun run_window(Scene scene, const WindowOptions& options);

}  // namespace planish::viewer
