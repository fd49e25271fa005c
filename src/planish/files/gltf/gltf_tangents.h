#pragma once

#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/surface/surface_blocks.h"

namespace planish {

/// Texture coordinates of normal textures on a surface.
struct TangentSource {
  std::vector<std::span<const glm::dvec2>> sets;  ///< one value for each of the surface's
  std::vector<int> set_of_group;                  ///< by the group of a face; -1: none is wanted
};

/// glTF's TANGENT: where u grows, of unit length and square to the normal, and whether v grows to
/// its left (1) or right (-1).
struct SurfaceTangents {
  /// Four numbers for each texture coordinate of the surface; zeros where none is wanted.
  RawVector<float> values;
  /// The same of texture coordinates on further rows, across sharp edges; ascending.
  std::vector<UvOnRow> further;
  std::vector<float> further_values;
};

/// They are those of MikkTSpace for the triangles that write_gltf() writes, of positions about 0 in
/// single precision, where no texture coordinate belongs to faces that lie either way round in the
/// texture; where a texture has no extent they are any square to the normal. Takes 24 bytes a
/// texture coordinate. Throws Error{Cancelled}.
/// Source: M. Mikkelsen, "Simulation of Wrinkled Surfaces Revisited", 2008, section 4, and the
/// program that goes with it.
[[nodiscard]] SurfaceTangents surface_tangents(const SurfaceBlocks& surface,
                                               const TangentSource& source);

}  // namespace planish
