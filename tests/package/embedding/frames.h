#pragma once

#include <planish/mesh/polygon_mesh.h>

#include <array>
#include <functional>
#include <glm/mat4x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec4.hpp>
#include <vector>

#include "application.h"

inline constexpr int kImageSide = 256;

/// What a frame has drawn, pixel by pixel.
struct DrawnFrame {
  std::vector<std::array<unsigned char, 4>> colours;
  std::vector<glm::vec4> motions;   ///< since the last frame; side of the bitangent, 0: background
  std::vector<glm::vec4> textures;  ///< u, v, x and y of the tangent
  std::vector<float> shadow;        ///< depths, 1: nothing
  /// The surface by the package's shader code, in patches as fine as the view wants; the fourth
  /// value is 255 where it is. Empty where the device has no tessellation.
  std::vector<std::array<unsigned char, 4>> patches;
};

/// A renderer's frames, two in flight: points skinned on the device, a textured surface through
/// them in compact formats, its shadow from positions alone, motion vectors from the last frame's
/// positions; and the same surface tessellated by the device, without vertices. `mesh` has texture
/// coordinates and stays within `half` of 0. `pose(frame)`: two bones, `view(frame)` what turns the
/// world before it is seen; `drawn(frame, images)` once the device has done it.
void render_frames(Application& app, const planish::PolygonMesh& mesh, float half, int frame_count,
                   const std::function<std::array<glm::mat4x3, 2>(int)>& pose,
                   const std::function<glm::mat4(int)>& view,
                   const std::function<void(int, const DrawnFrame&)>& drawn);
