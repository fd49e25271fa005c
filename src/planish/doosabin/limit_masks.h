#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "planish/doosabin/subdivision.h"
#include "planish/mesh/check.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/solve/stencil_table.h"

namespace planish {

/// The matrix B of the interpolation: row v gives the limit point of vertex v from all control
/// points. Smooth and dart vertices: mean of the corner points around them (the paper, equation
/// (1)); crease and boundary vertices: (previous + 6 own + next) / 8 along the curve; corners:
/// themselves. Rows sum to 1. Throws Error{UnusableMesh} where too_large_masks() says why.
[[nodiscard]] StencilTable limit_masks(const Subdivision& subdivision);

/// A row names every vertex of every face around its own, so that a face of m corners costs up to
/// m^2 entries: the problem where those of all faces may be more than 2^24 and eight times those of
/// summed_limit_masks(), or than 2^31 - 1. The fair method needs no masks.
[[nodiscard]] std::optional<MeshProblem> too_large_masks(const MeshTopology& topology);

/// B with the sums of large faces (FaceSumRule) apart, so that these take entries in proportion to
/// their corners; its products differ from those of limit_masks() by rounding. Throws as that.
[[nodiscard]] SummedTable summed_limit_masks(const Subdivision& subdivision);

/// Of those the problem.
[[nodiscard]] std::optional<MeshProblem> too_large_summed_masks(const MeshTopology& topology);

/// Lower bound of B's spectrum, from the face sizes alone.
[[nodiscard]] double spectral_bound(const PolygonMesh& mesh, Weights weights);

/// True for a closed mesh without sharp features: B is self-adjoint in the inner product weighted
/// by valence, as conjugate gradients need.
[[nodiscard]] bool is_self_adjoint(const SharpFeatures& features);

/// The valence of each vertex.
[[nodiscard]] std::vector<double> valences(const MeshTopology& topology);

}  // namespace planish
