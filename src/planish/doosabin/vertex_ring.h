#pragma once

#include <cstdint>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/doosabin/subdivision.h"
#include "planish/solve/stencil_builder.h"
#include "planish/solve/stencil_table.h"

namespace planish {

/// Rows of the state of level 1 from control points: one Doo-Sabin step.
[[nodiscard]] StencilTable first_step_table(const Subdivision& subdivision, RowRange rows);

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

/// Adds `scale` times the next level's control point of the face at place `i` of the ring, by the
/// rule of the ring's vertex.
void add_refined_face(const FaceWeights& face_weights, const VertexRing& ring, std::int32_t i,
                      double scale, std::vector<double>& weights_scratch, StencilRow& row);

/// The same for the curve control point of the half of a sharp edge at the ring's vertex, which is
/// `own` in the ring's numbers; of two sharp edges for a crease, of any for a corner or dart.
void add_refined_curve_point(const FaceWeights& face_weights, const VertexRing& ring,
                             std::int32_t own, std::vector<double>& weights_scratch,
                             StencilRow& row);

/// Adds the limit point with the derivatives of the given sector.
void add_limit(const VertexRing& ring, std::int32_t sector, StencilRow& row);

}  // namespace planish
