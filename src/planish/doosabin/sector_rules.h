#pragma once

#include <cstdint>
#include <vector>

#include "planish/doosabin/face_rule.h"
#include "planish/doosabin/vertex_ring.h"
#include "planish/stencil/stencil_builder.h"

namespace planish {

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
