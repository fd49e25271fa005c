#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/solve/backend.h"
#include "planish/solve/stencil_table.h"

namespace planish {

enum class Solver {
  Chebyshev,           ///< Chebyshev semi-iteration on [spectral_bound, 1], count fixed in advance
  Plain,               ///< the paper: V <- V + (V0 - B V)
  ConjugateGradients,  ///< closed smooth meshes only; on the host, whatever the backend
};

enum class StopReason {
  Converged,
  IterationLimit,
  Stagnated,  ///< the error no longer falls: the device's precision ends above the tolerance
  Singular,   ///< the same because B has, to rounding, no inverse; set by fit()
  Diverged,
};
[[nodiscard]] const char* name_of(StopReason reason);

struct InterpolationOptions {
  Solver solver = Solver::Chebyshev;
  double tolerance = 1e-6;  ///< of the maximum error, relative to the bounding-box diagonal
  std::int32_t max_iterations = 200;
  double spectral_bound = 0.25;  ///< lower bound of B's spectrum
  /// Conjugate gradients: valence per row. Empty for the other solvers.
  std::span<const double> row_weights;
  Callbacks callbacks;
};

struct Interpolation {
  std::vector<glm::dvec3> displacement;  ///< control point minus given point, unit coordinates
  bool converged = false;
  StopReason stop_reason = StopReason::Converged;
  std::int32_t iterations = 0;
  ErrorNorms error;  ///< after the last iteration
  std::int64_t worst_vertex = -1;
  std::vector<ErrorNorms> history;  ///< entry k: after k iterations
  double upload_milliseconds = 0;   ///< to put the limit masks on the device
};

/// The loop of interpolate() for the solvers Chebyshev and Plain, on any system whose displacement
/// is 0 and whose residual is `initial_error` long: which steps are taken and when they end. Adds
/// to the result's iterations and history, and sets its stop reason. Throws Error{Cancelled}.
void take_steps(StepSolve& solve, double initial_error, const InterpolationOptions& options,
                Interpolation& result);

/// Says whether `result.error`, measured in double after the last step, is within the tolerance.
void conclude(const InterpolationOptions& options, Interpolation& result);

/// Solves B (given + displacement) = given for the displacement. `given` in unit coordinates
/// (Placement), one per row of `limit_masks`; rows of unused vertices are identities.
/// Throws Error{InvalidArgument} for options out of range and Error{Cancelled}.
/// Source: the paper, section 3.2; Golub & Varga 1961 for the Chebyshev semi-iteration.
[[nodiscard]] Interpolation interpolate(Backend& backend, const SummedView& limit_masks,
                                        std::span<const glm::dvec3> given,
                                        const InterpolationOptions& options);

}  // namespace planish
