#pragma once

#include <opensubdiv/far/topologyRefiner.h>

#include <memory>

#include "planish/mesh/polygon_mesh.h"
#include "planish/solve/refiner.h"

namespace planish::test {

/// The refiner that OpenSubdiv makes of the faces' vertices alone, finding edges and the order
/// around vertices itself; attributes and options as make_refiner(). Null where it refuses the
/// mesh.
[[nodiscard]] std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> descriptor_refiner(
    const PolygonMesh& mesh, const RefinerOptions& options);

}  // namespace planish::test
