// Based on: Doo & Sabin, "Behaviour of recursive division surfaces near extraordinary points",
// 1978; "Smooth Surface Reconstruction using Doo-Sabin Subdivision Surfaces", equation (1).
#include "planish/doosabin/face_rule.h"

#include <cmath>
#include <numbers>

#include "planish/core/assert.h"

namespace planish {

std::vector<double> face_weights(Weights weights, std::int32_t m) {
  PLANISH_ASSERT(m >= 2);
  std::vector<double> c(static_cast<std::size_t>(m), 0.0);
  if (weights == Weights::Averaged) {
    // Own vertex 1/4 + 2 * 1/8 (both edge midpoints), each neighbour 1/8, centroid 1/(4m). Adding
    // the parts makes m = 2 right, where both neighbours are the same vertex.
    for (double& weight : c) weight = 0.25 / m;
    c[0] += 0.5;
    c[1] += 0.125;
    c[m - 1] += 0.125;
  } else {
    for (std::int32_t j = 0; j < m; ++j) {
      c[j] = (3.0 + 2.0 * std::cos(2.0 * std::numbers::pi * j / m)) / (4.0 * m);
    }
    c[0] += 0.25;
  }
  return c;
}

FaceWeights::FaceWeights(Weights weights) : weights_(weights) {
  for (std::int32_t m = 2; m <= kCachedSize; ++m) cached_[m] = face_weights(weights, m);
}

std::span<const double> FaceWeights::of(std::int32_t m, std::vector<double>& scratch) const {
  if (m <= kCachedSize) return cached_[m];
  if (static_cast<std::int32_t>(scratch.size()) != m) scratch = face_weights(weights_, m);
  return scratch;
}

double smallest_face_eigenvalue(Weights weights, std::int32_t m) {
  if (weights == Weights::Averaged) {
    // 1/2 + cos(2 pi k / m) / 4 with the k nearest to m/2.
    return m % 2 == 0 ? 0.25 : 0.5 - std::cos(std::numbers::pi / m) / 4.0;
  }
  return m <= 3 ? 0.5 : 0.25;
}

}  // namespace planish
