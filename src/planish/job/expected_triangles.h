#pragma once

#include "planish/job/output_plan.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/mesh/prepared_mesh.h"

namespace planish {

/// At most about how many triangles a tessellation to an adaptive fineness takes, told from how
/// much the mesh turns at its edges: between a face's middle and each edge the surface bends by
/// half of that. `prepared` is of `mesh`.
[[nodiscard]] double expected_triangles(const PolygonMesh& mesh, const PreparedMesh& prepared,
                                        const Fineness& fineness);

}  // namespace planish
