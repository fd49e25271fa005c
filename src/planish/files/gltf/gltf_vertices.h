#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/surface/surface_blocks.h"

namespace planish {

/// Faces of one group: a primitive of the file.
struct GltfPart {
  std::int32_t group = -1;  ///< -1: the surface has no groups
  std::uint64_t face_count = 0, triangle_count = 0;
  std::vector<RowRange> faces;  ///< ascending
};

/// A surface as glTF has it, with one texture coordinate a vertex and one material a primitive.
/// What is empty is as in the surface.
struct GltfVertices {
  std::vector<std::int32_t> rows;   ///< position of each vertex behind the surface's own
  std::vector<std::int32_t> uvs;    ///< texture coordinate of each vertex; -1: none
  RawVector<std::int32_t> corners;  ///< vertex of each corner
  std::vector<GltfPart> parts;      ///< one for each group that has faces, at least one

  [[nodiscard]] std::int64_t count(const SurfaceBlocks& surface) const {
    return surface.info().row_count + static_cast<std::int64_t>(rows.size());
  }
};

/// Splits vertices along the seams of the texture coordinates and sorts faces by group. The
/// surface's vertices stay the first, in their order: each takes the texture coordinate of its
/// first corner, every other gets a vertex of its own behind them.
[[nodiscard]] GltfVertices gltf_vertices(const SurfaceBlocks& surface);

}  // namespace planish
