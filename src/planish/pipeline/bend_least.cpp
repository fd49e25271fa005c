#include "planish/pipeline/bend_least.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numeric>

#include "planish/core/host_scope.h"
#include "planish/core/parallel.h"
#include "planish/fair/least_bending.h"
#include "planish/mesh/folded_edges.h"
#include "planish/surface/block_quality.h"

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

// What must not grow: bending at level 1, and folds as a report of level 1 or 2 has them.
struct Measured {
  SurfaceQuality quality;
  std::array<double, 4> folds{};

  [[nodiscard]] bool folds_more_than(const Measured& other) const {
    for (std::size_t i = 0; i < folds.size(); ++i)
      if (folds[i] > other.folds[i]) return true;
    return false;
  }
};

SurfaceQuality quality_at(int level, const PolygonMesh& mesh, const Fit& fit, Backend& backend,
                          const FitOptions& options) {
  EvaluateOptions evaluation;
  evaluation.level = level;
  evaluation.scheme = options.scheme;
  evaluation.weights = options.weights;
  evaluation.sharp = options.sharp;
  if (options.scheme != Scheme::DooSabin)
    return surface_quality(evaluate(mesh, fit, backend, evaluation), mesh);
  return surface_quality(*fitted_surface(mesh, fit, evaluation)->level(level), mesh,
                         folded_edges(mesh, *fit.prepared->topology).is_beside, {});
}

Measured measured_surface(const PolygonMesh& mesh, const Fit& fit, Backend& backend,
                          const FitOptions& options) {
  Measured result{quality_at(kBendingLevel, mesh, fit, backend, options)};
  const SurfaceQuality finer = quality_at(kBendingLevel + 1, mesh, fit, backend, options);
  result.folds = {result.quality.folded_area, result.quality.folded_area_elsewhere,
                  finer.folded_area, finer.folded_area_elsewhere};
  return result;
}

// Bounds that are tried, each half of the one before.
constexpr int kMostBounds = 10;

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

void leave_vertices(const PolygonMesh& mesh, Backend& backend, const FitOptions& options,
                    Fit& result) {
  const UsedPart used = used_part(mesh, result.prepared);
  std::vector<glm::dvec3> given(used.vertices.size());
  parallel_each(given.size(), [&](std::size_t v) {
    given[v] = result.placement.to_unit(used.mesh.positions[v]);
  });
  const BendingTable table =
      make_bending_table(*result.prepared->topology, *result.features, given);
  WithinFit& within = result.within.emplace(leave_within(options.within, table, given));
  const double bound = within.bound(options.tolerance);
  if (!(bound > 0)) return;
  const Measured exact = measured_surface(mesh, result, backend, options);
  within.exact = within.left = exact.quality;
  FitOptions trying = options;
  trying.prepared = result.prepared;
  RoundParts rounds(options.callbacks, 0.5);
  double part = bound;
  for (int i = 0; i < kMostBounds && part > options.tolerance; ++i, part *= 0.5) {
    trying.callbacks = rounds.next();
    const LeastBending least = least_bending_moves(table, given, part);
    if (i == 0) result.within->bending_before = result.within->bending_after = least.bending_before;
    std::vector<glm::dvec3> points(mesh.positions.begin(), mesh.positions.end());
    parallel_each(given.size(), [&](std::size_t v) {
      points[used.vertices[v]] = result.placement.to_model(given[v] + least.moves[v]);
    });
    Fit next = fit_through(mesh, std::move(points), backend, trying);
    const Measured found = measured_surface(mesh, next, backend, options);
    const bool is_better = found.quality.bending < result.within->left->bending &&
                           !found.folds_more_than(exact) &&
                           (next.interpolation.converged || !result.interpolation.converged);
    if (!is_better && !result.points.empty()) return;
    if (!is_better) continue;
    next.within = std::move(result.within);
    next.within->left = found.quality;
    next.within->bending_after = least.bending_after;
    next.within->distance = {};
    next.within->at_bound = 0;
    measure(least.moves, bound, nullptr, *next.within);
    result = std::move(next);
  }
}

}  // namespace planish
