#include "bench/agreement.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace planish::bench {

void require_agreement(std::string_view what, std::span<const glm::dvec3> actual,
                       std::span<const glm::dvec3> expected) {
  double largest = 0, difference = 0;
  bool usable = actual.size() == expected.size();
  for (std::size_t i = 0; usable && i < actual.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      usable = usable && std::isfinite(actual[i][k]);
      largest = std::max(largest, std::abs(expected[i][k]));
      difference = std::max(difference, std::abs(actual[i][k] - expected[i][k]));
    }
  }
  if (usable && difference <= kAgreement * largest) return;
  throw std::runtime_error(std::string(what) +
                           ": computes something else: " + std::to_string(actual.size()) + " of " +
                           std::to_string(expected.size()) + " points, off by " +
                           std::to_string(difference) + " of " + std::to_string(largest));
}

}  // namespace planish::bench
