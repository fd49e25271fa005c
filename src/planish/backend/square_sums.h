#pragma once

#include <algorithm>
#include <cmath>
#include <glm/vec3.hpp>
#include <limits>

#include "planish/backend/point_lanes.h"

namespace planish {

/// Over the residuals of a piece of rows.
struct PieceSums {
  double max_square = 0;
  glm::dvec3 sum{0.0};

  void add(const PieceSums& other) {
    max_square = std::max(max_square, other.max_square);
    sum += other.sum;
  }
};

/// Squares of residuals, in registers while rows go by.
class SquareSums {
 public:
  template <class Real>
  void add(const PointLanes<Real>& residual) {
    const PointLanes<double> squares = (residual * residual).in_double();
    sum_ = sum_ + squares;
    const PointLanes<double>::Register pair = squares.xy + squares.z0;
    const double square = pair[0] + pair[1];
    if (square > max_square_) max_square_ = square;
  }

  // Comparisons pass a NaN by, sums do not.
  [[nodiscard]] PieceSums total() const {
    const glm::dvec3 sum = sum_.point();
    const bool is_nan = std::isnan(sum.x + sum.y + sum.z);
    return {is_nan ? std::numeric_limits<double>::infinity() : max_square_, sum};
  }

 private:
  PointLanes<double> sum_{};
  double max_square_ = 0;
};

}  // namespace planish
