#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/mesh/polygon_mesh.h"
#include "planish/patches/patch_surface.h"
#include "planish/vulkan/evaluate/texture_rows.h"
#include "planish/vulkan/host/kept_faces.h"

namespace planish::vulkan {

struct SurfaceRecords;

/// The surface at one of the levels that a Tessellation chooses from.
struct LevelRecords {
  LevelRecords(const SurfaceRecords& surface, int level);

  PatchSurface patches;
  std::vector<RowFrame> frames;                  // of textured rows
  std::size_t first_index = 0, index_count = 0;  // of LevelSet::triangles
  /// Between its triangles and the surface in the rest pose, for a sphere of radius 1 around the
  /// control points.
  double chord = 0;
};

/// All of them, ascending.
struct LevelSet {
  std::deque<LevelRecords> levels;
  std::vector<std::uint32_t> triangles;
  double radius = 0;  ///< of the rest pose's sphere
};

/// The sphere around a box of points, as choose_levels makes it.
[[nodiscard]] double sphere_radius(std::span<const glm::dvec3> points);

/// `hull`: points whose hull holds the surface in the rest pose, in the coordinates of its state.
/// `radius` is in these.
[[nodiscard]] LevelSet make_levels(const PolygonMesh& mesh, const SurfaceRecords& surface,
                                   std::span<const glm::dvec3> hull, const PosedSurface& rest,
                                   std::span<const int> levels);

}  // namespace planish::vulkan
