#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/solve/backend.h"
#include "planish/solve/stencil_table.h"

namespace planish {

/// given - B given, one per row: sum_j b_ij (given_i - given_j), so that rounding is relative to
/// the differences and rows need not sum to 1 to the last bit.
[[nodiscard]] RawVector<glm::dvec3> initial_residual(const SummedView& limit_masks,
                                                     std::span<const glm::dvec3> given);

/// The sums of points.
[[nodiscard]] RawVector<glm::dvec3> sums_of(const SummedView& table,
                                            std::span<const glm::dvec3> points);

/// The coefficients of the Chebyshev semi-iteration for a spectrum in [bound, 1], 0 < bound < 1,
/// one step after another. Source: Golub & Varga, "Chebyshev semi-iterative methods", 1961.
class ChebyshevSequence {
 public:
  explicit ChebyshevSequence(double bound)
      : theta_((1 + bound) / 2), delta_((1 - bound) / 2), rho_(delta_ / theta_) {}

  StepCoefficients next();

 private:
  double theta_, delta_, rho_;
  bool first_ = true;
};

/// The first `count` of them.
[[nodiscard]] std::vector<StepCoefficients> chebyshev_steps(double bound, std::int32_t count);

/// Steps after which 2 sigma^k, the semi-iteration's bound on what is left of an error, is at most
/// `factor` (above 0); not below 0.
[[nodiscard]] double chebyshev_step_count(double bound, double factor);

}  // namespace planish
