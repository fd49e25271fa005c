#pragma once

#include <opensubdiv/far/topologyRefiner.h>
#include <opensubdiv/sdc/types.h>

#include <memory>

#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

struct RefinerOptions {
  OpenSubdiv::Sdc::SchemeType scheme = OpenSubdiv::Sdc::SCHEME_BILINEAR;
  SharpFeatureOptions sharp;  ///< what becomes OpenSubdiv's edge and vertex sharpness
};

/// OpenSubdiv's topology of a mesh that passes check() and has no unused vertices, whose
/// connectivity is at hand. Face-varying channel 0 holds the mesh's texture coordinates, refined
/// linearly, corners without one naming one more value than the mesh has. Throws
/// Error{UnusableMesh} should OpenSubdiv refuse it.
[[nodiscard]] std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> make_refiner(
    const PolygonMesh& mesh, const RefinerOptions& options, const MeshTopology& topology);

}  // namespace planish
