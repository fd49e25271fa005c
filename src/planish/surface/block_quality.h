#pragma once

#include "planish/mesh/polygon_mesh.h"
#include "planish/surface/surface_blocks.h"
#include "planish/surface/surface_quality.h"

namespace planish {

/// surface_quality() against the faces of the mesh that was fitted, of a surface of level 1 or more
/// that is made piece by piece on all threads; the same bits whatever their number. Angles are
/// within 1e-6 of a degree. `is_beside_folds`: one per face of the input, as FoldedEdges has it, or
/// nothing. Throws Error{Cancelled}.
[[nodiscard]] SurfaceQuality surface_quality(const SurfaceBlocks& surface, const PolygonMesh& input,
                                             std::span<const std::uint8_t> is_beside_folds,
                                             const Callbacks& callbacks);

}  // namespace planish
