#pragma once

#include <cstdint>
#include <vector>

#include "planish/doosabin/subdivision.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/stencil/stencil_table.h"

namespace planish {

/// The matrix B of the interpolation: row v gives the limit point of vertex v from all control
/// points. Smooth and dart vertices: mean of the corner points around them (the paper, equation
/// (1)); crease and boundary vertices: (previous + 6 own + next) / 8 along the curve; corners:
/// themselves. Rows sum to 1. Throws Error{OutOfMemory} past 2^31 - 1 entries.
[[nodiscard]] StencilTable limit_masks(const Subdivision& subdivision);

/// Lower bound of B's spectrum, from the face sizes alone.
[[nodiscard]] double spectral_bound(const PolygonMesh& mesh, Weights weights);

/// True for a closed mesh without sharp features: B is self-adjoint in the inner product weighted
/// by valence, as conjugate gradients need.
[[nodiscard]] bool is_self_adjoint(const SharpFeatures& features);

/// The valence of each vertex.
[[nodiscard]] std::vector<double> valences(const MeshTopology& topology);

}  // namespace planish
