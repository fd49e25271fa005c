#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "planish/mesh/polygon_mesh.h"
#include "planish/patches/chart_field.h"
#include "planish/patches/patch_surface.h"

namespace planish::vulkan {

/// What files of a mesh's surface go by, besides its shape.
struct FileFaces {
  explicit FileFaces(const PolygonMesh& mesh);

  std::vector<std::uint8_t> hidden;  ///< a flag a face; empty: none is
  std::vector<std::int32_t> groups;  ///< one a face, or nothing
  std::optional<CornerUvs> uvs;      ///< where it has texture coordinates
};

/// Of each row of a surface the vertex that files have in its place, counted through their
/// primitives; -1: none, as only hidden faces name the row.
[[nodiscard]] std::vector<std::int32_t> file_vertices(const PatchSurface& patches,
                                                      const FileFaces& faces);

}  // namespace planish::vulkan
