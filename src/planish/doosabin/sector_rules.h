#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "planish/doosabin/subdivision.h"
#include "planish/doosabin/vertex_ring.h"
#include "planish/stencil/stencil_builder.h"

namespace planish {

/// Adds `scale` times the next level's control point of the face at place `i` of the ring, by the
/// rule of the ring's vertex.
void add_refined_face(const Subdivision& subdivision, const VertexRing& ring, std::int32_t i,
                      double scale, std::vector<double>& weights_scratch, StencilRow& row);

/// Adds the limit point with the derivatives of the given sector.
void add_limit(const VertexRing& ring, std::int32_t sector, StencilRow& row);

}  // namespace planish
