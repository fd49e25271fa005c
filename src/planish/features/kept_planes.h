#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "planish/features/find_features.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// A vertex at the smooth border of a plane, where the plane is the tangent plane of the surface.
struct KeptPlane {
  std::int32_t vertex;
  std::int32_t face;  ///< of the plane, at the vertex

  friend auto operator<=>(const KeptPlane&, const KeptPlane&) = default;
};

/// Where planes stay planes up to their borders: where the surface beyond explains all of the turn
/// there, or nearly, as a fillet does, so that nothing of it is left to the plane. Beside a facet
/// of a smooth surface that explains half. Ascending; at most one between two sharp edges at a
/// vertex. `is_sharp`: one per edge of the topology, boundary edges included.
[[nodiscard]] std::vector<KeptPlane> find_kept_planes(const PolygonMesh& mesh,
                                                      const MeshTopology& topology,
                                                      std::span<const char> is_sharp,
                                                      const FeatureRules& rules = {});

}  // namespace planish
