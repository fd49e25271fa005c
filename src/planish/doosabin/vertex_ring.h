#pragma once

#include <cstdint>
#include <vector>

#include "planish/doosabin/subdivision.h"

namespace planish {

/// The control points around one vertex of Q_1, the mesh with its faces cut into quads, as indices
/// into the state of level 1: its vertices are the mesh's, then one per face, then one per edge.
struct VertexRing {
  /// Faces between two sharp edges, counter-clockwise.
  struct Sector {
    std::int32_t first, count;    ///< range of `faces`
    std::int32_t curve0, curve1;  ///< curve control points of the edges before and after
    CornerSector corner = CornerSector::Convex;  ///< meaningful where the kind is Corner
  };

  VertexKind kind = VertexKind::Smooth;
  std::vector<std::int32_t> faces;  ///< face control points, counter-clockwise
  std::vector<Sector> sectors;      ///< empty at smooth and dart vertices
  std::int32_t corner_point = -1;   ///< corner vertices: their position
  std::int32_t dart_face = -1;      ///< darts: the entry of `faces` after the sharp edge
};

/// Gathers the ring of a vertex of Q_1. Reuse `ring` to avoid allocation.
void gather_ring(const Subdivision& subdivision, std::int32_t vertex, VertexRing& ring);

}  // namespace planish
