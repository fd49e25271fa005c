#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <span>

#include "planish/distributed/mesh_part.h"
#include "planish/distributed/part_tiles.h"
#include "planish/distributed/sub_mesh.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/surface/doo_sabin_surface.h"
#include "planish/surface/level_one.h"

namespace planish {

/// The surface over a block's faces and those around them (Rings::Whole): of a cage, one point per
/// local vertex of the part, or of the control points that the options name.
class BlockSurface {
 public:
  /// The faces have been found sound. `limits`: where the whole surface has the part's vertices, by
  /// local vertex; none where nothing rides on it. `colors`: DooSabinSurface::take_whole().
  BlockSurface(const MeshPart& part, std::span<const glm::dvec3> cage, const SubMesh& sub,
               const PartTilesOptions& options, std::span<const glm::dvec3> limits = {},
               const std::vector<glm::vec4>& colors = {});
  BlockSurface(const BlockSurface&) = delete;
  BlockSurface& operator=(const BlockSurface&) = delete;

  [[nodiscard]] const DooSabinSurface& surface() const { return *surface_; }

 private:
  PolygonMesh cage_;
  LevelOne level_one_;
  std::optional<DooSabinSurface> surface_;
};

}  // namespace planish
