#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "planish/brep/analytic_faces.h"
#include "planish/core/callbacks.h"
#include "planish/features/find_features.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish::test {

/// A mesh whose features are found, for analytic faces of it.
class AnalyticCase {
 public:
  explicit AnalyticCase(const PolygonMesh& mesh, std::span<const std::int32_t> groups = {})
      : mesh_(mesh),
        groups_(groups),
        topology_(mesh),
        is_sharp_(static_cast<std::size_t>(topology_.edge_count()), 0) {
    for (const CreaseEdge& crease : find_features(mesh, topology_).sharp_edges())
      is_sharp_[static_cast<std::size_t>(topology_.find_edge(crease.v0, crease.v1))] = 1;
  }
  [[nodiscard]] AnalyticMesh mesh() const {
    return {.topology = topology_,
            .positions = mesh_.positions,
            .is_sharp = is_sharp_,
            .groups = groups_,
            .diagonal = placement_of(mesh_).diagonal};
  }
  [[nodiscard]] AnalyticParts found(std::optional<double> tolerance = {},
                                    const Callbacks& callbacks = {}) const {
    return find_analytic_parts(mesh(), tolerance, callbacks);
  }

 private:
  const PolygonMesh& mesh_;
  std::span<const std::int32_t> groups_;
  MeshTopology topology_;
  std::vector<char> is_sharp_;
};

/// Its analytic faces without freeform ones beside them.
inline AnalyticFaces analytic_faces_of(const PolygonMesh& mesh,
                                       std::span<const std::int32_t> groups = {},
                                       const Callbacks& callbacks = {},
                                       std::optional<double> tolerance = {}) {
  const AnalyticCase of(mesh, groups);
  return make_analytic_faces(of.mesh(), of.found(tolerance, callbacks), nullptr, callbacks);
}

}  // namespace planish::test
