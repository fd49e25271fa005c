#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "planish/doosabin/subdivision.h"
#include "planish/fair/fair_topology.h"
#include "planish/features/kept_planes.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// Where control points lie in a plane of the mesh: a face of it for each polygon and each sector,
/// -1 where there is none. Both empty: nowhere.
struct PlanePlaces {
  std::vector<std::int32_t> of_vertex;  ///< of crease vertices that of any of their sectors
  std::vector<std::int32_t> of_sector;  ///< as FairTopology::sectors

  [[nodiscard]] std::int32_t of(std::int32_t vertex) const {
    return of_vertex.empty() ? -1 : of_vertex[vertex];
  }
  [[nodiscard]] std::int32_t of_sector_at(std::int32_t sector) const {
    return of_sector.empty() ? -1 : of_sector[sector];
  }
};

/// Those of find_kept_planes() between what is sharp in a subdivision of the mesh.
[[nodiscard]] std::vector<KeptPlane> kept_planes(const PolygonMesh& mesh,
                                                 const Subdivision& subdivision);

/// Corners have none: there the edges are the tangents.
[[nodiscard]] PlanePlaces plane_places(const FairTopology& topology,
                                       std::span<const KeptPlane> planes);

}  // namespace planish
