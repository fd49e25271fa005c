#include "planish/pipeline/linear_surface.h"

#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"

namespace planish {
namespace {

constexpr std::size_t kVertexGrain = 4096;

// Finer than float32 holds, whatever the tolerance of positions is.
constexpr double kTolerance = 1e-8;

LimitSystem system_of(const FittedMesh& fitted) {
  const UsedPart used = used_part(fitted.mesh, fitted.fit.prepared);
  const MeshTopology& topology = *used.prepared->topology;
  const SharpFeatures features =
      find_sharp_features(used.mesh, topology, used.mesh.positions, fitted.options.sharp);
  FitOptions options = fitted.options;
  options.callbacks = {};
  options.solver = Solver::Chebyshev;
  return doo_sabin_system(used.mesh, Subdivision(topology, features, options.weights), options);
}

}  // namespace

LinearSurface::LinearSurface(const FittedMesh& fitted, Backend& backend)
    : fitted_(fitted), backend_(backend), system_(system_of(fitted)) {}

EvaluateOptions LinearSurface::options() const {
  EvaluateOptions options = fitted_.evaluate_options();
  options.rest_positions = fitted_.mesh.positions;
  options.prepared = fitted_.fit.prepared;
  return options;
}

LinearSurface::Through LinearSurface::through(std::span<const glm::dvec3> given,
                                              const Callbacks& callbacks) const {
  const UsedPart used = used_part(fitted_.mesh, fitted_.fit.prepared);
  RawVector<glm::dvec3> values(used.vertices.size());
  parallel_each(values.size(), kVertexGrain,
                [&](std::size_t v) { values[v] = given[used.vertices[v]]; });
  InterpolationOptions interpolation;
  interpolation.tolerance = kTolerance;
  interpolation.spectral_bound = system_.spectral_bound;
  interpolation.callbacks.progress = callbacks.progress;
  interpolation.callbacks.cancelled = callbacks.cancelled;
  const Interpolation solved = interpolate(backend_, system_.masks.view(), values, interpolation);
  Through made;
  auto cage = std::make_unique<PolygonMesh>(fitted_.mesh);
  parallel_each(values.size(), kVertexGrain, [&](std::size_t v) {
    cage->positions[used.vertices[v]] = values[v] + solved.displacement[v];
  });
  made.cage = std::move(cage);
  made.surface = std::make_unique<const DooSabinSurface>(*made.cage, Placement{}, options());
  return made;
}

LinearSurface::Through LinearSurface::moved(const DooSabinSurface& base,
                                            std::span<const glm::dvec3> moves,
                                            const Callbacks& callbacks) const {
  const Through by = through(moves, callbacks);
  const auto size = static_cast<std::size_t>(base.patches().state_size());
  auto sum = std::make_unique<LevelOne>();
  sum->placement = base.placement();
  sum->state.resize(size);
  parallel_each(size, kVertexGrain, [&](std::size_t i) {
    sum->state[i] = base.state()[i] + by.surface->state()[i] / base.placement().diagonal;
  });
  Through made;
  made.level_one = std::move(sum);
  made.surface = std::make_unique<const DooSabinSurface>(fitted_.mesh, *made.level_one, options());
  return made;
}

}  // namespace planish
