#pragma once

#include <cstdint>
#include <vector>

#include "planish/doosabin/surface_stencils.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// The faces of Q_level by rows of `rows`, which are of level max(level, 1): at level 0 one entry
/// per corner of the mesh, in its order; else four per quad.
[[nodiscard]] std::vector<std::int32_t> face_rows(const PolygonMesh& mesh, const QuadSplit& split,
                                                  int level, const LimitRows& rows);

}  // namespace planish
