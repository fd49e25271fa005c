#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/patches/chart_field.h"
#include "planish/patches/patch_surface.h"

namespace planish::vulkan {

/// A surface in one pose.
struct PosedSurface {
  std::span<const glm::dvec3> state;  ///< points of level 1, with the sums of large rings
  Placement placement;                ///< what they are in coordinates of
};

/// Corners of faces that are no holes, ascending.
[[nodiscard]] std::vector<std::int32_t> kept_corners(const PolygonMesh& mesh,
                                                     const MeshTopology& topology);

/// Rows at the corners of the output's faces, without those of holes, in the order of the files
/// that `planish fit` writes.
struct KeptFaces {
  std::vector<std::uint32_t> triangles;  ///< cut as in those files, by their positions in the pose
  std::vector<std::uint32_t> quads;      ///< empty at level 0
};
[[nodiscard]] KeptFaces kept_faces(const PolygonMesh& mesh, const PatchSurface& patches,
                                   const PosedSurface& pose);

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
