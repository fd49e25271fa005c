// Based on: Golub & Varga, "Chebyshev semi-iterative methods", 1961.
#include "planish/backend/chebyshev.h"

#include <algorithm>
#include <cmath>

namespace planish {

StepCoefficients ChebyshevSequence::next() {
  if (first_) {
    first_ = false;
    return {0.0, 1.0 / theta_};
  }
  const double next_rho = 1.0 / (2.0 * theta_ / delta_ - rho_);
  const StepCoefficients step{next_rho * rho_, 2.0 * next_rho / delta_};
  rho_ = next_rho;
  return step;
}

std::vector<StepCoefficients> chebyshev_steps(double bound, std::int32_t count) {
  ChebyshevSequence sequence(bound);
  std::vector<StepCoefficients> steps(static_cast<std::size_t>(count));
  for (StepCoefficients& step : steps) step = sequence.next();
  return steps;
}

double chebyshev_step_count(double bound, double factor) {
  const double root = std::sqrt(1.0 / bound);
  const double sigma = (root - 1) / (root + 1);
  return std::max(std::ceil(std::log(2 / factor) / -std::log(sigma)), 0.0);
}

}  // namespace planish
