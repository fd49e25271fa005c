#pragma once

namespace planish::viewer {

inline constexpr int kMostIterations = 64;
inline constexpr int kMostLevel = 5;  // of the slider and --level

/// What flags set at first and a window's panel changes.
struct ViewSettings {
  int level = 2;
  int iterations = 6;  ///< of each frame
  bool warm_start = true;
  bool surface = true, cage = false, points = false, heat = false;
  bool texture = false;     ///< a board by texture coordinates, where the mesh has some
  bool tessellate = false;  ///< the surface as fine as it is seen, without errors and texture
  bool paused = false;

  [[nodiscard]] bool draws_squares() const { return texture && !heat; }
  [[nodiscard]] bool draws_patches() const { return tessellate && !heat && !texture; }
};

}  // namespace planish::viewer
