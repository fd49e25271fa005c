#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "planish/brep/analytic_faces.h"
#include "planish/brep/brep.h"
#include "planish/brep/free_borders.h"
#include "planish/mesh/mesh_topology.h"

namespace planish {

/// Of these regions of a part those that are in the way of faces, whatever B-spline faces they end
/// at; without them others may be. Throws NotAnalytic where no region is to blame.
[[nodiscard]] std::vector<std::int32_t> regions_in_the_way(const AnalyticParts& found,
                                                           const MeshTopology& topology,
                                                           std::span<const std::int32_t> regions);

/// The part of a B-rep, in unit coordinates: the faces of these regions in their order, and behind
/// them these of `freeform`, which may be null where there are none. Throws NotAnalytic.
[[nodiscard]] Brep analytic_part(const AnalyticParts& found, const MeshTopology& topology,
                                 std::span<const std::int32_t> regions,
                                 const FreeformFaces* freeform,
                                 std::span<const std::int32_t> freeform_faces);

}  // namespace planish
