#pragma once

#include <vector>

#include "planish/doosabin/subdivision.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/pipeline/fit.h"
#include "planish/primal/primal_split.h"
#include "planish/stencil/stencil_table.h"

namespace planish {

/// The linear system of the interpolation, B P = V0, and what is known of it.
struct LimitSystem {
  SummedTable masks;          ///< B
  double spectral_bound = 0;  ///< above 0 and below 1; what the Chebyshev semi-iteration takes
  /// Estimate of B's smallest eigenvalue; at or near 0 B is singular, below it no iteration
  /// converges.
  double smallest_eigenvalue = 0;
  std::vector<double> row_weights;  ///< for conjugate gradients; empty for the other solvers
};

// Both throw as fit().

[[nodiscard]] LimitSystem doo_sabin_system(const PolygonMesh& mesh, const Subdivision& subdivision,
                                           const FitOptions& options);

/// The split must have a level 1.
[[nodiscard]] LimitSystem primal_system(const PrimalSplit& split, const FitOptions& options);

}  // namespace planish
