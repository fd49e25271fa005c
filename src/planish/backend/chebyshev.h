#pragma once

#include <cstdint>
#include <vector>

#include "planish/backend/backend.h"

namespace planish {

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
