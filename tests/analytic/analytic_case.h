#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "planish/brep/analytic_faces.h"
#include "planish/core/callbacks.h"
#include "planish/features/find_features.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish::test {

/// The analytic faces of a mesh whose features are found, without freeform ones beside them.
inline AnalyticFaces analytic_faces_of(const PolygonMesh& mesh,
                                       std::span<const std::int32_t> groups = {},
                                       const Callbacks& callbacks = {}, double tolerance = 1.5e-6) {
  const MeshTopology topology(mesh);
  std::vector<char> is_sharp(static_cast<std::size_t>(topology.edge_count()), 0);
  for (const CreaseEdge& crease : find_features(mesh, topology).sharp_edges())
    is_sharp[static_cast<std::size_t>(topology.find_edge(crease.v0, crease.v1))] = 1;
  const AnalyticMesh analytic{.topology = topology,
                              .positions = mesh.positions,
                              .is_sharp = is_sharp,
                              .groups = groups,
                              .diagonal = placement_of(mesh).diagonal};
  return make_analytic_faces(analytic, find_analytic_parts(analytic, tolerance, callbacks), nullptr,
                             callbacks);
}

}  // namespace planish::test
