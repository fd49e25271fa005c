#include "planish/pipeline/limit_system.h"

#include <algorithm>
#include <string>

#include "planish/core/error.h"
#include "planish/doosabin/limit_masks.h"
#include "planish/primal/primal_stencils.h"
#include "planish/primal/spectrum.h"

namespace planish {

namespace {

// Where the least eigenvalue is smaller than this, or unknown. With too large a bound the Chebyshev
// semi-iteration still converges for every eigenvalue in (0, 1], only slower; with too small a one
// it takes its time for all. 1/100 costs three times the steps of Doo-Sabin's 1/4 and a half.
constexpr double kLeastBound = 0.01;

// What an estimate is lowered by, since the smallest Ritz value comes from above.
constexpr double kEstimateMargin = 0.9;

void require_solver_fits(const FitOptions& options, bool self_adjoint, int sharp_edges,
                         int corners) {
  if (options.solver != Solver::ConjugateGradients || self_adjoint) return;
  throw Error(ErrorCode::InvalidArgument,
              formatted("the solver cg needs a closed mesh without creases and corners, and this "
                        "one has {} boundary or crease edges and {} corners; take chebyshev",
                        sharp_edges, corners));
}

}  // namespace

LimitSystem doo_sabin_system(const PolygonMesh& mesh, const Subdivision& subdivision,
                             const FitOptions& options) {
  const SharpFeatures& features = subdivision.features();
  require_solver_fits(options, is_self_adjoint(features), features.sharp_edge_count,
                      features.corner_count);
  LimitSystem system{summed_limit_masks(subdivision)};
  system.spectral_bound = spectral_bound(mesh, options.weights);
  system.smallest_eigenvalue = system.spectral_bound;
  if (options.solver == Solver::ConjugateGradients) {
    system.row_weights = valences(subdivision.topology());
  }
  return system;
}

LimitSystem primal_system(const PrimalSplit& split, const FitOptions& options) {
  LimitSystem system{{primal_limit_masks(split), {}}};
  const Spectrum spectrum = primal_spectrum(split, system.masks.rows.view());
  require_solver_fits(options, spectrum.self_adjoint, split.sharp_edge_count(),
                      split.corner_count());
  const double smallest = spectrum.smallest * (spectrum.proven ? 1.0 : kEstimateMargin);
  system.spectral_bound = std::clamp(smallest, kLeastBound, 0.9);
  system.smallest_eigenvalue = spectrum.smallest;
  if (options.solver == Solver::ConjugateGradients) system.row_weights = primal_row_weights(split);
  return system;
}

}  // namespace planish
