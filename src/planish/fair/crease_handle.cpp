#include "planish/fair/crease_handle.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace planish {

using glm::dvec3;

namespace {

// Where arms differ by more than this part of the shorter, the handle is the chord's alone.
constexpr double kUnevenArms = 0.4;
// A handle may pass the shorter arm by this factor.
constexpr double kLongestFactor = 1.15;

}  // namespace

CreaseArms crease_arms(const FairTopology& topology, std::span<const dvec3> given,
                       std::int32_t vertex) {
  const auto [before, after] = topology.crease_neighbours(vertex);
  return {(given[before] - given[vertex]) / 4.0, (given[after] - given[vertex]) / 4.0};
}

double imbalance(const CreaseArms& arms) {
  const double before = glm::length(arms.before), after = glm::length(arms.after);
  const double shorter = std::min(before, after);
  if (!(shorter > 0)) return std::numeric_limits<double>::infinity();
  return std::abs(before - after) / shorter;
}

dvec3 chord_handle(const CreaseArms& arms) {
  const double before = glm::length(arms.before), after = glm::length(arms.after);
  if (!(before > 0) || !(after > 0)) return dvec3(0.0);
  const dvec3 direction = arms.before / (before * before) - arms.after / (after * after);
  const double length = glm::length(direction);
  if (!(length > 0)) return dvec3(0.0);  // a cusp: both arms the same way
  return direction *
         (std::min((before + after) / 2, kLongestFactor * std::min(before, after)) / length);
}

dvec3 crease_handle(const CreaseArms& arms, double rho) {
  const double chord_share = std::min(rho / kUnevenArms, 1.0);
  const dvec3 mean = (arms.before - arms.after) / 2.0;
  return (1 - chord_share) * mean + chord_share * chord_handle(arms);
}

}  // namespace planish
