#include "planish/reconstruct/edge_gradation.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <limits>

namespace planish {
namespace {

// Squared lengths of the edges at a vertex, the shortest and the longest.
struct EdgeRange {
  double shortest = std::numeric_limits<double>::infinity(), longest = 0;

  void add(const glm::dvec3& edge) {
    const double squared = glm::dot(edge, edge);
    shortest = std::min(shortest, squared);
    longest = std::max(longest, squared);
  }
};

}  // namespace

double EdgeGradation::squared_ratio(std::int32_t vertex, const EdgeChange& change) const {
  EdgeRange range;
  mesh_.for_each_neighbour(vertex, [&](std::int32_t other) {
    if (other != change.without) range.add(positions_[vertex] - positions_[other]);
  });
  if (change.with != nullptr) range.add(positions_[vertex] - *change.with);
  return range.longest / range.shortest;
}

bool EdgeGradation::keeps(std::int32_t vertex, const EdgeChange& change) const {
  const double after = squared_ratio(vertex, change);
  return after <= largest_squared_ratio_ || after <= squared_ratio(vertex, {});
}

bool EdgeGradation::keeps_all(std::int32_t vertex, const Fan& fan, std::size_t target) const {
  const std::int32_t other = fan.ring[target];
  EdgeRange range;
  double worst = 0;
  const std::size_t count = fan.ring.size();
  for (std::size_t i = 0; i < count; ++i) {
    const std::int32_t rim = fan.ring[i];
    if (rim == other) continue;
    // Those beside the target only lose an edge, which makes no ratio worse.
    const std::size_t apart = i < target ? target - i : i - target;
    const bool is_beside = apart == 1 || (fan.closed && apart + 1 == count);
    if (!is_beside)
      worst = std::max(worst, squared_ratio(rim, {.without = vertex, .with = &positions_[other]}));
    range.add(positions_[other] - positions_[rim]);
  }
  mesh_.for_each_neighbour(other, [&](std::int32_t n) {
    if (n != vertex) range.add(positions_[other] - positions_[n]);
  });
  const auto fits = [&](double limit) {
    return worst <= limit && range.longest <= limit * range.shortest;
  };
  if (fits(largest_squared_ratio_)) return true;
  // Where a vertex is beyond the limit all around it only need to become no worse than the worst:
  // points in lines far apart would keep every one of them else.
  const auto was_as_bad = [&](std::int32_t v) { return fits(squared_ratio(v, {})); };
  return was_as_bad(vertex) || std::ranges::any_of(fan.ring, was_as_bad);
}

bool EdgeGradation::keeps_moved(std::int32_t vertex, const glm::dvec3& place,
                                const Fan& fan) const {
  EdgeRange range;
  for (const std::int32_t rim : fan.ring) {
    if (!keeps(rim, {.without = vertex, .with = &place})) return false;
    range.add(place - positions_[rim]);
  }
  return range.longest <=
         std::max(largest_squared_ratio_, squared_ratio(vertex, {})) * range.shortest;
}

}  // namespace planish
