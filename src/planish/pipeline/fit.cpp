// Based on: "Smooth Surface Reconstruction using Doo-Sabin Subdivision Surfaces", section 3: a
// polygon mesh in, the control mesh of the interpolating Doo-Sabin surface out.
#include "planish/pipeline/fit.h"

#include <algorithm>
#include <chrono>
#include <string>

#include "planish/doosabin/limit_masks.h"
#include "planish/mesh/check.h"
#include "planish/mesh/used_vertices.h"
#include "planish/pipeline/solve_fair.h"
#include "planish/stencil/quad_split.h"

namespace planish {

namespace {

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
  if (!options.sharp.use_tags) return;
  std::int64_t count = 0;
  const CreaseEdge* first = nullptr;
  for (const CreaseEdge& crease : mesh.creases) {
    if (crease.sharpness <= 0 || crease.sharpness >= kInfiniteSharpness) continue;
    if (count++ == 0) first = &crease;
  }
  if (count == 0) return;
  options.callbacks.warn(
      {"semi-sharp-creases",
       "creases of a sharpness below 10, taken as smooth: " + std::to_string(count) +
           ", the first of them edge " + std::to_string(first->v0) + "-" +
           std::to_string(first->v1) + "; give 10 for a sharp edge",
       count, first->v0});
}

void require_solver_fits(Solver solver, const SharpFeatures& features) {
  if (solver != Solver::ConjugateGradients || is_self_adjoint(features)) return;
  throw Error(ErrorCode::InvalidArgument,
              "the solver cg needs a closed mesh without creases and corners, and this one has " +
                  std::to_string(features.sharp_edge_count) + " boundary or crease edges and " +
                  std::to_string(features.corner_count) + " corners; take chebyshev");
}

// The iteration of the paper, or one of its accelerations, in coordinates of unit diagonal.
void solve_progressive(Fit& result, const UsedMesh& used, const Subdivision& subdivision,
                       std::span<const glm::dvec3> given, Backend& backend,
                       const FitOptions& options, Stopwatch& watch) {
  const StencilTable<double> masks = limit_masks(used.mesh, subdivision);
  result.spectral_bound = spectral_bound(used.mesh, options.weights);
  result.stencil_entries = static_cast<std::int64_t>(masks.GetWeights().size());
  result.timing.stencils = watch.lap();

  std::vector<double> row_weights;
  if (options.solver == Solver::ConjugateGradients) row_weights = valences(subdivision.split());
  InterpolationOptions interpolation;
  interpolation.solver = options.solver;
  interpolation.tolerance = options.tolerance;
  interpolation.max_iterations = options.max_iterations;
  interpolation.spectral_bound = result.spectral_bound;
  interpolation.row_weights = row_weights;
  interpolation.callbacks = options.callbacks;
  result.interpolation = interpolate(backend, masks.view(), given, interpolation);
  result.timing.upload = result.interpolation.upload_milliseconds;
  result.timing.solve = watch.lap() - result.timing.upload;

  for (std::size_t v = 0; v < given.size(); ++v) {
    result.cage.positions[used.vertices[v]] +=
        result.placement.diagonal * result.interpolation.displacement[v];
  }
}

}  // namespace

Fit fit(const PolygonMesh& mesh, Backend& backend, const FitOptions& options) {
  Stopwatch watch;
  Fit result;
  require_usable(mesh, "mesh");
  const UsedMesh used = without_unused_vertices(mesh);
  warn_of_semi_sharp(mesh, options);
  result.placement = placement_of(used.mesh);
  result.timing.check = watch.lap();

  // Topology, once on the CPU.
  options.callbacks.report("stencils", 0);
  const QuadSplit split(used.mesh);
  result.timing.topology = watch.lap();
  const SharpFeatures features =
      find_sharp_features(used.mesh, split, used.mesh.positions, options.sharp);
  result.sharp_edge_count = features.sharp_edge_count;
  result.boundary_edge_count = features.sharp_edge_count - features.interior_sharp_edge_count;
  result.corner_count = features.corner_count;

  std::vector<glm::dvec3> given(used.mesh.positions.size());
  std::transform(used.mesh.positions.begin(), used.mesh.positions.end(), given.begin(),
                 [&](const glm::dvec3& p) { return result.placement.to_unit(p); });
  if (options.method == InterpolationMethod::Fair) {
    // Its first step takes the weights of 1978 whatever the later levels take.
    solve_fair(result, used.mesh, Subdivision(split, features, Weights::DooSabin), given, options);
    result.timing.solve = watch.lap();
  } else {
    require_solver_fits(options.solver, features);
    result.cage = mesh;
    solve_progressive(result, used, Subdivision(split, features, options.weights), given, backend,
                      options, watch);
  }
  if (result.interpolation.worst_vertex >= 0) {
    result.interpolation.worst_vertex = used.vertices[result.interpolation.worst_vertex];
  }
  return result;
}

SurfaceMesh evaluate(const PolygonMesh& mesh, const Fit& fit, Backend& backend,
                     const EvaluateOptions& options) {
  EvaluateOptions posed = options;
  if (posed.rest_positions.empty()) posed.rest_positions = mesh.positions;
  return fit.fair ? evaluate(mesh, fit.fair->level_one, backend, posed)
                  : evaluate(fit.cage, backend, posed);
}

PolygonMesh control_cage(const PolygonMesh& mesh, const Fit& fit,
                         const SharpFeatureOptions& sharp) {
  return fit.fair ? level_one_mesh(mesh, fit.fair->level_one, sharp) : fit.cage;
}

}  // namespace planish
