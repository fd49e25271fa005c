#include "planish/pipeline/fit.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <glm/geometric.hpp>
#include <numeric>
#include <string>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/doosabin/limit_masks.h"
#include "planish/fair/bending.h"
#include "planish/fair/semi_sharp.h"
#include "planish/measure/figures.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/pipeline/fit_steps.h"
#include "planish/primal/primal_stencils.h"
#include "planish/surface/level_one_mesh.h"

namespace planish {
namespace {

// Where the least eigenvalue is smaller than this, or unknown. With too large a bound the Chebyshev
// semi-iteration still converges for every eigenvalue in (0, 1], only slower; with too small a one
// it takes its time for all. 1/100 costs three times the steps of Doo-Sabin's 1/4 and a half.
constexpr double kLeastBound = 0.01;

// What an estimate is lowered by, since the smallest Ritz value comes from above.
constexpr double kEstimateMargin = 0.9;

void require_solver_fits(const FitOptions& options, bool self_adjoint, int sharp_edges,
                         int corners) {
  if (options.solver != Solver::ConjugateGradients || self_adjoint) return;
  throw Error(ErrorCode::InvalidArgument,
              formatted("the solver cg needs a closed mesh without creases and corners, and this "
                        "one has {} boundary or crease edges and {} corners; take chebyshev",
                        sharp_edges, corners));
}

}  // namespace

LimitSystem doo_sabin_system(const PolygonMesh& mesh, const Subdivision& subdivision,
                             const FitOptions& options) {
  const SharpFeatures& features = subdivision.features();
  require_solver_fits(options, is_self_adjoint(features), features.sharp_edge_count,
                      features.corner_count);
  LimitSystem system{summed_limit_masks(subdivision)};
  system.spectral_bound = spectral_bound(mesh, options.weights);
  system.smallest_eigenvalue = system.spectral_bound;
  if (options.solver == Solver::ConjugateGradients) {
    system.row_weights = valences(subdivision.topology());
  }
  return system;
}

LimitSystem primal_system(const PrimalSplit& split, const FitOptions& options) {
  LimitSystem system{{primal_limit_masks(split), {}}};
  const Spectrum spectrum = primal_spectrum(split, system.masks.rows.view());
  require_solver_fits(options, spectrum.self_adjoint, split.sharp_edge_count(),
                      split.corner_count());
  const double smallest = spectrum.smallest * (spectrum.proven ? 1.0 : kEstimateMargin);
  system.spectral_bound = std::clamp(smallest, kLeastBound, 0.9);
  system.smallest_eigenvalue = spectrum.smallest;
  if (options.solver == Solver::ConjugateGradients) system.row_weights = primal_row_weights(split);
  return system;
}

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

Measured measured_surface(const PolygonMesh& mesh, const Fit& fit, const FitOptions& options) {
  const SurfaceMeter meter(
      mesh, fit, {.scheme = options.scheme, .weights = options.weights, .sharp = options.sharp});
  Measured result{meter.at(kBendingLevel)};
  const SurfaceQuality finer = meter.at(kBendingLevel + 1);
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
  const Measured exact = measured_surface(mesh, result, options);
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
    const Measured found = measured_surface(mesh, next, options);
    const bool is_better = found.quality.bending < result.within->left->bending &&
                           !found.folds_more_than(exact) &&
                           (next.interpolation.converged || !result.interpolation.converged);
    if (!is_better && !result.points.empty()) return;
    if (!is_better) continue;
    next.within.emplace(*std::move(result.within));
    next.within->left = found.quality;
    next.within->bending_after = least.bending_after;
    next.within->distance = {};
    next.within->at_bound = 0;
    measure(least.moves, bound, nullptr, *next.within);
    result = std::move(next);
  }
}

namespace {

// Based on: "Smooth Surface Reconstruction using Doo-Sabin Subdivision Surfaces", section 3: a
// polygon mesh in, the control mesh of the interpolating subdivision surface out.

constexpr std::size_t kGrain = 4096;

// Shares of the time when the mesh is checked, its sharp features are known, the system is made.
constexpr double kChecked = 0.15, kTopologyKnown = 0.3, kSystemMade = 0.5;
// Of the time, the fit through the given vertices where they may be left.
constexpr double kExactOfLeaving = 0.3;

class Stopwatch {
 public:
  // Milliseconds since the last call, or since it was made.
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const std::chrono::duration<double, std::milli> time = now - last_;
    last_ = now;
    return time.count();
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

bool obeys_semi_sharp(const PolygonMesh& mesh, const FitOptions& options) {
  return options.method == InterpolationMethod::Fair && options.obeys_semi_sharp &&
         options.sharp.use_tags && has_semi_sharp(mesh);
}

void warn_of_semi_sharp(const PolygonMesh& mesh, const FitOptions& options) {
  // OpenSubdiv's own schemes obey them.
  if (!options.sharp.use_tags || options.scheme != Scheme::DooSabin ||
      obeys_semi_sharp(mesh, options))
    return;
  std::int64_t count = 0;
  const CreaseEdge* first = nullptr;
  for (const CreaseEdge& crease : mesh.creases) {
    if (crease.sharpness <= 0 || crease.sharpness >= kInfiniteSharpness) continue;
    if (count++ == 0) first = &crease;
  }
  if (count == 0) return;
  options.callbacks.warn({"semi-sharp-creases",
                          formatted("creases of a sharpness below 10, taken as smooth: {}, the "
                                    "first of them edge {}-{}; fair interpolation obeys them, 10 "
                                    "is a sharp edge",
                                    count, first->v0, first->v1),
                          count, first->v0});
}

void require_method_fits(const FitOptions& options) {
  if (options.method == InterpolationMethod::Progressive || options.scheme == Scheme::DooSabin) {
    return;
  }
  throw Error(
      ErrorCode::InvalidArgument,
      "fair interpolation builds control points of Doo-Sabin's level 1, which Catmull-Clark "
      "and Loop do not have; take progressive");
}

// Why no progress is made where B is to blame. Eigenvalues nearer to 0 than this make none within
// any sensible number of steps; where one is negative its part of the error grows.
void explain_stagnation(const LimitSystem& system, Interpolation& interpolation) {
  constexpr double kSingular = 1e-3;
  if (interpolation.stop_reason != StopReason::Stagnated) return;
  if (system.smallest_eigenvalue < -kSingular) {
    interpolation.stop_reason = StopReason::Diverged;
  } else if (system.smallest_eigenvalue < kSingular) {
    interpolation.stop_reason = StopReason::Singular;
  }
}

// The iteration of the paper, or one of its accelerations, in coordinates of unit diagonal.
void solve_progressive(Fit& result, const LimitSystem& system, std::span<const glm::dvec3> given,
                       Backend& backend, const FitOptions& options, Stopwatch& watch) {
  result.spectral_bound = system.spectral_bound;
  result.stencil_entries = system.masks.entry_count();
  result.timing.stencils = watch.lap();

  InterpolationOptions interpolation;
  interpolation.solver = options.solver;
  interpolation.tolerance = options.tolerance;
  interpolation.max_iterations = options.max_iterations;
  interpolation.spectral_bound = result.spectral_bound;
  interpolation.row_weights = system.row_weights;
  interpolation.callbacks = share_of(options.callbacks, kSystemMade, 0.95);
  result.interpolation = interpolate(backend, system.masks.view(), given, interpolation);
  explain_stagnation(system, result.interpolation);
  result.timing.upload = result.interpolation.upload_milliseconds;
  result.timing.solve = watch.lap() - result.timing.upload;
}

// The mesh with its vertices moved.
void move_to_cage(Fit& result, const PolygonMesh& mesh, const UsedPart& used) {
  result.cage = mesh;
  if (!result.points.empty()) std::ranges::copy(result.points, result.cage.positions.begin());
  parallel_each(used.vertices.size(), kGrain, [&](std::size_t v) {
    result.cage.positions[used.vertices[v]] +=
        result.placement.diagonal * result.interpolation.displacement[v];
  });
}

void fit_doo_sabin(Fit& result, const UsedPart& used, std::span<const glm::dvec3> given,
                   Backend& backend, const FitOptions& options, Stopwatch& watch) {
  const MeshTopology& topology = *used.prepared->topology;
  const SharpFeatures& features = *result.features;
  result.timing.topology = watch.lap();
  result.sharp_edge_count = features.sharp_edge_count;
  result.boundary_edge_count = features.sharp_edge_count - features.interior_sharp_edge_count;
  result.corner_count = features.corner_count;
  if (options.method == InterpolationMethod::Fair) {
    FitOptions solve = options;
    solve.callbacks = share_of(options.callbacks, kTopologyKnown, 0.95);
    std::optional<PolygonMesh> moved;
    if (!result.points.empty()) {
      moved = used.mesh;
      parallel_each(given.size(), kGrain,
                    [&](std::size_t v) { moved->positions[v] = result.points[used.vertices[v]]; });
    }
    const PolygonMesh& mesh = moved ? *moved : used.mesh;
    // Its first step takes the weights of 1978 whatever the later levels take.
    const Subdivision subdivision(topology, features, Weights::DooSabin);
    const bool is_semi_sharp = obeys_semi_sharp(used.mesh, options);
    if (is_semi_sharp) solve.callbacks = share_of(options.callbacks, kTopologyKnown, 0.6);
    solve_fair(result, mesh, subdivision, given, backend, solve);
    if (is_semi_sharp) {
      solve.callbacks = share_of(options.callbacks, 0.6, 0.95);
      solve_semi_sharp(result, mesh, subdivision,
                       find_sharp_features(with_semi_sharp_as_sharp(used.mesh), topology,
                                           used.mesh.positions, options.sharp),
                       given, backend, solve);
    }
    result.timing.solve = watch.lap();
  } else {
    options.callbacks.report("stencils", kTopologyKnown);
    const Subdivision subdivision(topology, features, options.weights);
    solve_progressive(result, doo_sabin_system(used.mesh, subdivision, options), given, backend,
                      options, watch);
  }
}

void fit_primal(Fit& result, const UsedPart& used, PrimalScheme scheme,
                std::span<const glm::dvec3> given, Backend& backend, const FitOptions& options,
                Stopwatch& watch) {
  PrimalSplit split(used.mesh, {scheme, options.sharp, used.prepared->topology.get()});
  split.refine(1);
  result.timing.topology = watch.lap();
  result.sharp_edge_count = split.sharp_edge_count();
  result.boundary_edge_count = split.boundary_edge_count();
  result.corner_count = split.corner_count();
  solve_progressive(result, primal_system(split, options), given, backend, options, watch);
}

// Through `points`, or where there are none through the given vertices.
Fit fitted(const PolygonMesh& mesh, std::vector<glm::dvec3> points, Backend& backend,
           const FitOptions& options) {
  Stopwatch watch;
  Fit result;
  result.points = std::move(points);
  result.prepared = options.prepared ? options.prepared : prepare_mesh(mesh, "mesh");
  const UsedPart used = used_part(mesh, result.prepared);
  // Before the solve, and by the mesh's own numbers.
  if (options.scheme == Scheme::DooSabin)
    (void)ring_columns(*used.prepared->topology, options.weights, used.vertices);
  warn_of_semi_sharp(mesh, options);
  result.placement = placement_of(used.mesh.positions);
  RawVector<glm::dvec3> given(used.mesh.positions.size());
  parallel_each(given.size(), kGrain, [&](std::size_t v) {
    given[v] = result.placement.to_unit(used.mesh.positions[v]);
  });
  result.timing.check = watch.lap();

  options.callbacks.report("stencils", kChecked);
  result.features = std::make_shared<const SharpFeatures>(
      find_sharp_features(used.mesh, *used.prepared->topology, used.mesh.positions, options.sharp));
  if (!result.points.empty()) {
    parallel_each(given.size(), kGrain, [&](std::size_t v) {
      given[v] = result.placement.to_unit(result.points[used.vertices[v]]);
    });
  }
  if (const auto scheme = primal_scheme(options.scheme)) {
    fit_primal(result, used, *scheme, given, backend, options, watch);
  } else {
    fit_doo_sabin(result, used, given, backend, options, watch);
  }
  // Here, in memory that the solve has given back.
  if (options.method == InterpolationMethod::Progressive) move_to_cage(result, mesh, used);
  result.timing.solve += watch.lap();
  if (result.interpolation.worst_vertex >= 0) {
    result.interpolation.worst_vertex = used.vertices[result.interpolation.worst_vertex];
  }
  return result;
}

}  // namespace

Fit fit(const PolygonMesh& mesh, Backend& backend, const FitOptions& options) {
  require_method_fits(options);
  const HostScope host(options.callbacks);
  options.callbacks.report("check", 0);
  Fit result;
  const bool may_leave = options.within != 0.0;
  FitOptions exact = options;
  if (may_leave) exact.callbacks = share_of(options.callbacks, 0, kExactOfLeaving);
  backend.run_on_host([&] {
    result = fitted(mesh, {}, backend, exact);
    if (!may_leave) return;
    FitOptions leaving = options;
    leaving.callbacks = share_of(options.callbacks, kExactOfLeaving, 1);
    leave_vertices(mesh, backend, leaving, result);
  });
  options.callbacks.report("solve", 1);
  return result;
}

Fit fit_through(const PolygonMesh& mesh, std::vector<glm::dvec3> points, Backend& backend,
                const FitOptions& options) {
  require_method_fits(options);
  const HostScope host(options.callbacks);
  Fit result;
  backend.run_on_host([&] { result = fitted(mesh, std::move(points), backend, options); });
  return result;
}

namespace {

// The options for a surface whose rest pose is the fitted mesh.
EvaluateOptions posed_options(const PolygonMesh& mesh, const Fit& fit,
                              const EvaluateOptions& options) {
  EvaluateOptions posed = options;
  if (posed.rest_positions.empty() && !posed.features) {
    posed.rest_positions = mesh.positions;
    posed.features = fit.features;
  }
  if (!posed.prepared) posed.prepared = fit.prepared;
  return posed;
}

}  // namespace

std::unique_ptr<const DooSabinSurface> fitted_surface(const PolygonMesh& mesh, const Fit& fit,
                                                      const EvaluateOptions& options) {
  const EvaluateOptions posed = posed_options(mesh, fit, options);
  return fit.fair ? std::make_unique<const DooSabinSurface>(mesh, fit.fair->level_one, posed)
                  : std::make_unique<const DooSabinSurface>(fit.cage, posed);
}

SurfaceMesh evaluate(const PolygonMesh& mesh, const Fit& fit, Backend& backend,
                     const EvaluateOptions& options) {
  const EvaluateOptions posed = posed_options(mesh, fit, options);
  return fit.fair ? evaluate(mesh, fit.fair->level_one, backend, posed)
                  : evaluate(fit.cage, backend, posed);
}

SurfaceMeter::SurfaceMeter(const PolygonMesh& mesh, const Fit& fit, const EvaluateOptions& options)
    : mesh_(mesh), fit_(fit), options_(posed_options(mesh, fit, options)) {
  if (options_.scheme != Scheme::DooSabin) return;
  surface_ = fitted_surface(mesh, fit, options_);
  is_beside_folds_ = folded_edges(mesh, *fit.prepared->topology).is_beside;
}

SurfaceQuality SurfaceMeter::at(int level, const Callbacks& callbacks) const {
  if (surface_) return surface_quality(*surface_->level(level), mesh_, is_beside_folds_, callbacks);
  EvaluateOptions options = options_;
  options.level = level;
  options.callbacks = callbacks;
  return surface_quality(evaluate(mesh_, fit_, *make_cpu_backend(), options), mesh_);
}

PartQuality SurfaceMeter::parts_at(int level, const PartOfFaces& parts,
                                   const Callbacks& callbacks) const {
  return quality_of_parts(*surface_->level(level), mesh_, is_beside_folds_, parts, callbacks);
}

PolygonMesh control_cage(const PolygonMesh& mesh, const Fit& fit,
                         const SharpFeatureOptions& sharp) {
  return fit.fair ? level_one_mesh({mesh, sharp, fit.prepared, fit.features}, fit.fair->level_one)
                  : fit.cage;
}

}  // namespace planish
