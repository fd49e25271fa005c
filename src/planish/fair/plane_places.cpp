#include "planish/fair/plane_places.h"

#include <algorithm>

namespace planish {

std::vector<KeptPlane> kept_planes(const PolygonMesh& mesh, const Subdivision& subdivision) {
  const MeshTopology& topology = subdivision.topology();
  std::vector<char> is_sharp(static_cast<std::size_t>(topology.edge_count()), 0);
  for (std::int32_t e = 0; e < topology.edge_count(); ++e)
    is_sharp[e] = subdivision.sharp_of_edge(e) >= 0 ? 1 : 0;
  return find_kept_planes(mesh, topology, is_sharp);
}

PlanePlaces plane_places(const FairTopology& topology, std::span<const KeptPlane> planes) {
  PlanePlaces places;
  if (planes.empty()) return places;
  places.of_vertex.assign(static_cast<std::size_t>(topology.vertex_count), -1);
  places.of_sector.assign(topology.sectors.size(), -1);
  for (const auto& [vertex, face] : planes) {
    if (topology.kind(vertex) == VertexKind::Corner) continue;
    places.of_vertex[vertex] = face;
    if (topology.has_polygon(vertex)) continue;
    const std::int32_t crease = topology.crease_of_vertex[vertex];
    for (std::int32_t s = topology.sector_offsets[crease]; s < topology.sector_offsets[crease + 1];
         ++s) {
      const auto is_of_plane = [&](std::int32_t corner) {
        return topology.corner_faces[corner] == face;
      };
      if (std::ranges::any_of(topology.ring(topology.sectors[s]).corners, is_of_plane))
        places.of_sector[s] = face;
    }
  }
  return places;
}

}  // namespace planish
