#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "planish/surface/surface_mesh.h"

namespace planish {

/// Faces of one group: a primitive of the file.
struct GltfPart {
  std::int32_t group = -1;  ///< -1: the surface has no groups
  std::uint64_t face_count = 0, triangle_count = 0;
};

/// A surface as glTF has it, with one texture coordinate a vertex and one material a primitive.
/// What is empty is as in the surface.
struct GltfVertices {
  std::vector<std::int32_t> rows;        ///< position of each vertex behind the surface's own
  std::vector<std::int32_t> uvs;         ///< texture coordinate of each vertex; -1: none
  std::vector<std::int32_t> corners;     ///< vertex of each corner
  std::vector<std::int32_t> face_order;  ///< the parts' faces, one part after another
  std::vector<GltfPart> parts;           ///< one for each group that has faces, at least one

  [[nodiscard]] std::size_t count(const SurfaceMesh& surface) const {
    return surface.positions.size() + rows.size();
  }
  [[nodiscard]] std::size_t row(const SurfaceMesh& surface, std::size_t vertex) const {
    const std::size_t own = surface.positions.size();
    return vertex < own ? vertex : static_cast<std::size_t>(rows[vertex - own]);
  }
};

/// Splits vertices along the seams of the texture coordinates and sorts faces by group. The
/// surface's vertices stay the first, in their order: each takes the texture coordinate of its
/// first corner, every other gets a vertex of its own behind them.
[[nodiscard]] GltfVertices gltf_vertices(const SurfaceMesh& surface);

}  // namespace planish
