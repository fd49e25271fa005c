#pragma once

#include <cstdint>

#include "planish/core/callbacks.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/surface/surface_blocks.h"

namespace planish {

/// How far the texture of a surface lies from where the mesh has it: at each place of the surface,
/// from the nearest place of the face that it descends from, whose texture coordinates are linear
/// on the triangles from its first corner. Weighted by area.
struct TextureSlide {
  double largest = 0, rms = 0;  ///< in parts of the texture, whose side is 1
  /// The same along the faces, in the model's unit; where a triangle has no area in the texture
  /// there is none.
  double largest_distance = 0, rms_distance = 0;
  std::int32_t face = -1;  ///< of the mesh, where the distance is largest; -1: nowhere
};

/// Of the corners of the surface's faces, on all threads; the same bits whatever their number. The
/// mesh is the fitted one, with texture coordinates. Throws Error{Cancelled}.
[[nodiscard]] TextureSlide texture_slide(const SurfaceBlocks& surface, const PolygonMesh& mesh,
                                         const Callbacks& callbacks = {});

}  // namespace planish
