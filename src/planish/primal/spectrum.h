#pragma once

#include <vector>

#include "planish/primal/primal_split.h"
#include "planish/stencil/stencil_table.h"

namespace planish {

/// What is known of the eigenvalues of a primal scheme's B.
struct Spectrum {
  double smallest = 0;  ///< estimate of the smallest; at or below 0 the iterations do not converge
  bool proven = false;  ///< `smallest` is a lower bound
  /// B is self-adjoint in the inner product of primal_row_weights(): closed without any sharpness.
  bool self_adjoint = false;
};

/// By formula where that gives a bound above 0: without semi-sharp edges and darts the rows of
/// smooth vertices, scaled, are symmetric and the others depend on themselves alone, so that B's
/// eigenvalues are real and above the least of (n - 3) / (n + 5) over the smooth valences n
/// (Catmull-Clark; (s - n / 2) / (s + n) with Loop, s the ratio of own weight to an edge's plus n,
/// see the source) and 1/3 (creases). Elsewhere by Lanczos on the rows of smooth vertices.
/// `limit_masks` are primal_limit_masks() of the split.
[[nodiscard]] Spectrum primal_spectrum(const PrimalSplit& split,
                                       const StencilView<double>& limit_masks);

/// Per vertex the factor that makes the rows of smooth vertices symmetric: n (n + 5) with
/// Catmull-Clark, 3 / (8 beta) + n with Loop, where beta is the weight of an edge in the scheme's
/// mask for the vertex.
[[nodiscard]] std::vector<double> primal_row_weights(const PrimalSplit& split);

}  // namespace planish
