#include "planish/pipeline/linear_surface.h"

#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/core/raw_vector.h"
#include "planish/limit/adaptive_blocks.h"
#include "planish/surface/evaluate.h"

namespace planish {
namespace {

constexpr std::size_t kVertexGrain = 4096;

// Finer than float32 holds, whatever the tolerance of positions is.
constexpr double kTolerance = 1e-8;

// The most that a surface may miss what it is to go through, of the numbers' extent.
constexpr double kLargestMiss = 1e-5;

// `surface`: of Doo-Sabin.
LimitSystem system_of(const FittedMesh& fitted, const DooSabinSurface* surface) {
  const UsedPart used = used_part(fitted.mesh, fitted.fit.prepared);
  const MeshTopology& topology = *used.prepared->topology;
  FitOptions options = fitted.options;
  options.callbacks = {};
  options.solver = Solver::Chebyshev;
  if (surface != nullptr) {
    const SharpFeatures& features = surface->patches().features();
    return doo_sabin_system(used.mesh, Subdivision(topology, features, options.weights), options);
  }
  PrimalSplit split(used.mesh, {*primal_scheme(options.scheme), options.sharp, &topology});
  split.refine(1);
  return primal_system(split, options);
}

}  // namespace

LinearSurface::LinearSurface(const FittedMesh& fitted, const SurfaceBlocks& rows, Backend& backend)
    : fitted_(fitted),
      rows_(rows),
      backend_(backend),
      fitted_surface_(is_doo_sabin()
                          ? fitted_surface(fitted.mesh, fitted.fit, fitted.evaluate_options())
                          : nullptr),
      system_(system_of(fitted, fitted_surface_.get())) {}

EvaluateOptions LinearSurface::options() const {
  return fitted_.evaluate_options(rows_.info().level);
}

std::unique_ptr<PolygonMesh> LinearSurface::cage_through(std::span<const glm::dvec3> given,
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
  if (!(solved.error.max <= kLargestMiss))
    throw Error(ErrorCode::InvalidArgument,
                "this scheme has no surface through what the vertices have, joints or morph "
                "targets; take --scheme doo-sabin, which always has one, or merge the scene "
                "(--asset merge)");
  auto cage = std::make_unique<PolygonMesh>(fitted_.mesh);
  parallel_each(values.size(), kVertexGrain, [&](std::size_t v) {
    cage->positions[used.vertices[v]] = values[v] + solved.displacement[v];
  });
  return cage;
}

LinearSurface::Rows LinearSurface::at_rows(Rows made) const {
  if (!is_doo_sabin()) {
    made.whole_ = std::make_unique<const SurfaceMesh>(evaluate(*made.cage_, backend_, options()));
    made.blocks_ = blocks_of(*made.whole_, fitted_.mesh);
  } else if (const auto* const adaptive = dynamic_cast<const AdaptiveBlocks*>(&rows_)) {
    made.whole_ =
        std::make_unique<const SurfaceMesh>(adaptive->rows_on(LimitSurface(made.surface_)));
    made.blocks_ = blocks_of(*made.whole_, PolygonMesh{});
  } else {
    made.blocks_ = made.surface_->level(rows_.info().level);
  }
  return made;
}

LinearSurface::Rows LinearSurface::through(std::span<const glm::dvec3> given,
                                           const Callbacks& callbacks) const {
  Rows made;
  made.cage_ = cage_through(given, callbacks);
  if (is_doo_sabin())
    made.surface_ = std::make_shared<const DooSabinSurface>(*made.cage_, Placement{}, options());
  return at_rows(std::move(made));
}

LinearSurface::Rows LinearSurface::moved(std::span<const glm::dvec3> moves,
                                         const Callbacks& callbacks) const {
  Rows made;
  std::unique_ptr<PolygonMesh> by = cage_through(moves, callbacks);
  if (!is_doo_sabin()) {
    parallel_each(by->positions.size(), kVertexGrain,
                  [&](std::size_t v) { by->positions[v] += fitted_.fit.cage.positions[v]; });
    made.cage_ = std::move(by);
    return at_rows(std::move(made));
  }
  const DooSabinSurface& base = *fitted_surface_;
  const DooSabinSurface mover(*by, Placement{}, options());
  const auto size = static_cast<std::size_t>(base.patches().state_size());
  auto sum = std::make_unique<LevelOne>();
  sum->placement = base.placement();
  sum->state.resize(size);
  parallel_each(size, kVertexGrain, [&](std::size_t i) {
    sum->state[i] = base.state()[i] + mover.state()[i] / base.placement().diagonal;
  });
  made.level_one_ = std::move(sum);
  made.surface_ =
      std::make_shared<const DooSabinSurface>(fitted_.mesh, *made.level_one_, options());
  return at_rows(std::move(made));
}

}  // namespace planish
