#pragma once

#include <cstdint>
#include <vector>

#include "planish/analytic/find_regions.h"
#include "planish/mesh/mesh_topology.h"

namespace planish {

/// Edges of a mesh between the same two regions, one after another.
struct BorderChain {
  std::int32_t left = -1, right = -1;  ///< regions; -1: faces of none, or nothing
  bool is_boundary = false;            ///< there is nothing to the right
  bool is_closed = false;              ///< the last vertex is the first one
  std::vector<std::int32_t> vertices;
};

/// A chain in the border of a region.
struct ChainUse {
  std::int32_t chain = 0;
  bool is_reversed = false;
};

/// How regions meet. Chains end where more than two regions do; faces of no region count as one.
struct RegionBorders {
  std::vector<BorderChain> chains;
  /// By region: its borders, each counter-clockwise around it.
  std::vector<std::vector<std::vector<ChainUse>>> loops;
};

[[nodiscard]] RegionBorders find_borders(const MeshTopology& topology,
                                         const AnalyticRegions& regions);

}  // namespace planish
