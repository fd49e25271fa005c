#include "planish/fair/balanced_weights.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace planish {

using glm::dvec2;

namespace {

// Newton's method converges quadratically once near; six steps give what twelve do.
constexpr int kNewtonSteps = 6;
// Of y, in units of one over the points' rms length: longer ones overshoot the exponential.
constexpr double kLongestStep = 1.5;
// Keeps the Hessian invertible where all points lie on a line.
constexpr double kDamping = 1e-9;
// What may remain of the sum, as a part of the weights' sum; the centroid is made exact later. At
// twice this the weights are useless.
constexpr double kTolerance = 1e-3;
// Points that need a larger weight surround 0 only just; at twice this the weights are useless.
constexpr double kLargestWeight = 15.0;

// 1 up to the limit, falling to 0 at twice the limit.
double ramp(double value, double limit) { return std::clamp(2 - value / limit, 0.0, 1.0); }

// Sets weights[i] = exp(-y . points[i] * scale) and returns their sum.
double set_weights(std::span<const dvec2> points, const dvec2& y, std::span<double> weights) {
  double sum = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    weights[i] = std::exp(-glm::dot(y, points[i]));
    sum += weights[i];
  }
  return sum;
}

}  // namespace

double balance(std::span<const dvec2> points, std::span<double> weights) {
  double square = 0;
  for (const dvec2& point : points) square += glm::dot(point, point);
  if (!(square > 0)) return 0;
  const double unit = static_cast<double>(points.size()) / square;  // 1 / rms^2

  // y is kept in units of 1 / length, so that no scaled copy of the points is needed.
  dvec2 y(0.0);
  std::fill(weights.begin(), weights.end(), 1.0);
  double sum = static_cast<double>(points.size());
  dvec2 moment(0.0);
  for (int step = 0;; ++step) {
    moment = dvec2(0.0);
    double xx = 0, xy = 0, yy = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const dvec2 weighted = weights[i] * points[i];
      moment += weighted;
      xx += weighted.x * points[i].x;
      xy += weighted.x * points[i].y;
      yy += weighted.y * points[i].y;
    }
    if (step == kNewtonSteps) break;
    xx += kDamping / unit;
    yy += kDamping / unit;
    const double determinant = xx * yy - xy * xy;
    if (!(determinant > 0)) return 0;
    dvec2 move(yy * moment.x - xy * moment.y, xx * moment.y - xy * moment.x);
    move /= determinant;
    const double length = std::sqrt(glm::dot(move, move) / unit);
    if (length > kLongestStep) move *= kLongestStep / length;
    y += move;
    sum = set_weights(points, y, weights);
  }
  const double largest = *std::max_element(weights.begin(), weights.end());
  const double left = std::sqrt(glm::dot(moment, moment) * unit) / sum;
  if (!std::isfinite(left) || !std::isfinite(largest)) return 0;
  return std::min(ramp(left, kTolerance), ramp(largest, kLargestWeight));
}

}  // namespace planish
