#include "planish/vulkan/evaluate/state_owners.h"

#include <algorithm>

namespace planish::vulkan {

std::vector<std::int32_t> state_owners(const PatchMesh& mesh) {
  const MeshTopology& topology = mesh.topology();
  const SharpFeatures& features = mesh.features();
  std::vector<std::int32_t> owners(static_cast<std::size_t>(mesh.point_count()));
  for (std::int32_t c = 0; c < topology.corner_count(); ++c) owners[c] = topology.vertex_of(c);
  for (std::int32_t e = 0; features.sharp_edge_count > 0 && e < topology.edge_count(); ++e) {
    const std::int32_t sharp = features.sharp_of_edge[e];
    if (sharp < 0) continue;
    const auto [v0, v1] = topology.edge_vertices(e);
    owners[mesh.first_sharp() + 2 * sharp] = v0;
    owners[mesh.first_sharp() + 2 * sharp + 1] = v1;
  }
  for (std::int32_t i = 0; i < features.corner_count; ++i)
    owners[mesh.first_corner_vertex() + i] = features.corner_vertices[i];
  for (const LargeRing& ring : mesh.large_rings())
    std::fill_n(owners.begin() + ring.first_sum, ring.sum_count(), topology.vertex_of(ring.start));
  return owners;
}

}  // namespace planish::vulkan
