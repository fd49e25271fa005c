#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <span>

#include "planish/fair/corner_offsets.h"
#include "planish/fair/fair_topology.h"

namespace planish {

/// What a sector's control points are built from.
struct SectorShape {
  glm::dvec3 handle;        ///< offset of the curve point before the first sector
  double share;             ///< of the tensor-product construction, 0 to 1
  glm::dvec3 tensor_shift;  ///< given - B P at the vertex
  /// Unit normal of the plane that the sector lies in; not given: that of its corners.
  std::optional<glm::dvec3> normal = std::nullopt;
};

/// Builds the control points of a crease or boundary sector in place of those in `offsets`, which
/// are of one step of the given points or of P: flat in the plane of the handle and the sector's
/// normal where share is 0, following the curve's handles beside the sharp edges. `step`: of
/// `given`.
void build_sector(const FairTopology& topology, std::span<const glm::dvec3> given,
                  const GivenStep& step, std::span<const glm::dvec3> face_normals,
                  const FairTopology::Sector& sector, const SectorShape& shape,
                  std::span<glm::dvec3> offsets);

}  // namespace planish
