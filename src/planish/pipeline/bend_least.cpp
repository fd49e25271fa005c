#include "planish/pipeline/bend_least.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numeric>

#include "planish/core/parallel.h"
#include "planish/fair/least_bending.h"

namespace planish {

namespace {

void measure(std::span<const glm::dvec3> moves, double bound, FairHalo* halo, WithinFit& within) {
  std::vector<double> squares(moves.size());
  std::int64_t count = 0;
  for (std::size_t v = 0; v < moves.size(); ++v) {
    const double distance = glm::length(moves[v]);
    squares[v] = distance * distance;
    if (!owns_vertex(halo, static_cast<std::int32_t>(v))) continue;
    ++count;
    within.distance.max = std::max(within.distance.max, distance);
    within.at_bound += distance >= (1 - 1e-9) * bound ? 1 : 0;
  }
  const double sum = halo == nullptr ? std::accumulate(squares.begin(), squares.end(), 0.0)
                                     : halo->sum_of_vertices(squares);
  within.distance.rms = std::sqrt(sum / static_cast<double>(sum_of_parts(halo, count)));
  within.at_bound = sum_of_parts(halo, within.at_bound);
  if (halo != nullptr) within.distance.max = halo->largest(within.distance.max);
}

}  // namespace

std::optional<WithinFit> bend_least(const MeshTopology& topology, const SharpFeatures& features,
                                    const Placement& placement, const FitOptions& options,
                                    std::span<glm::dvec3> points, FairHalo* halo) {
  if (options.within == 0.0) return {};
  const BendingTable table = make_bending_table(topology, features, points);
  WithinFit within{leave_within(options.within, table, points)};
  const double bound = within.bound(options.tolerance);
  if (!(bound > 0)) return within;
  const LeastBending least = least_bending_moves(table, points, bound, halo);
  measure(least.moves, bound, halo, within);
  within.bending_before = least.bending_before;
  within.bending_after = least.bending_after;
  // They are what a file could say of them.
  parallel_each(points.size(), [&](std::size_t v) {
    points[v] = placement.to_unit(placement.to_model(points[v] + least.moves[v]));
  });
  return within;
}

}  // namespace planish
