// Based on: "Smooth Surface Reconstruction using Doo-Sabin Subdivision Surfaces", section 3: a
// polygon mesh in, the control mesh of the interpolating subdivision surface out.
#include "planish/pipeline/fit.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <glm/geometric.hpp>
#include <string>

#include "planish/core/formatted.h"
#include "planish/core/host_scope.h"
#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/pipeline/bend_least.h"
#include "planish/pipeline/limit_system.h"
#include "planish/pipeline/solve_fair.h"
#include "planish/surface/level_one_mesh.h"
#include "planish/surface/subdivided_mesh.h"

namespace planish {

namespace {

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

void warn_of_semi_sharp(const PolygonMesh& mesh, const FitOptions& options) {
  // OpenSubdiv's own schemes obey them.
  if (!options.sharp.use_tags || options.scheme != Scheme::DooSabin) return;
  std::int64_t count = 0;
  const CreaseEdge* first = nullptr;
  for (const CreaseEdge& crease : mesh.creases) {
    if (crease.sharpness <= 0 || crease.sharpness >= kInfiniteSharpness) continue;
    if (count++ == 0) first = &crease;
  }
  if (count == 0) return;
  options.callbacks.warn({"semi-sharp-creases",
                          formatted("creases of a sharpness below 10, taken as smooth: {}, the "
                                    "first of them edge {}-{}; give 10 for a sharp edge",
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
    // Its first step takes the weights of 1978 whatever the later levels take.
    solve_fair(result, moved ? *moved : used.mesh,
               Subdivision(topology, features, Weights::DooSabin), given, backend, solve);
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

}  // namespace

namespace {

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

PolygonMesh control_cage(const PolygonMesh& mesh, const Fit& fit,
                         const SharpFeatureOptions& sharp) {
  return fit.fair ? level_one_mesh({mesh, sharp, fit.prepared, fit.features}, fit.fair->level_one)
                  : fit.cage;
}

}  // namespace planish
