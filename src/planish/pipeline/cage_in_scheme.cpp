#include "planish/pipeline/cage_in_scheme.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <numeric>
#include <span>
#include <vector>

#include "planish/core/guards.h"
#include "planish/core/parallel.h"
#include "planish/core/words.h"
#include "planish/pipeline/fit.h"
#include "planish/pipeline/option_table.h"
#include "planish/primal/primal_stencils.h"
#include "planish/solve/iteration.h"
#include "planish/solve/progressive.h"

namespace planish {
namespace {

// Steps of conjugate gradients: more would follow eigenvalues near 0 far away from the vertices for
// little of the distance.
constexpr int kGradientSteps = 48;
// Where the gradient is this much smaller than the residual nothing is left to gain.
constexpr double kNoGradient = 1e-7;

using Points = std::vector<glm::dvec3>;

StencilTable transposed(const StencilView<double>& table) {
  StencilTable made;
  made.sizes.assign(static_cast<std::size_t>(table.source_count), 0);
  for (const std::int32_t source : table.indices) ++made.sizes[source];
  made.indices.resize(table.indices.size());
  made.weights.resize(table.weights.size());
  made.close(table.row_count());
  RawVector<std::int32_t> next = made.offsets;
  for (std::int32_t row = 0; row < table.row_count(); ++row) {
    for (std::int32_t k = table.offsets[row]; k < table.offsets[row] + table.sizes[row]; ++k) {
      const std::int32_t place = next[table.indices[k]]++;
      made.indices[place] = row;
      made.weights[place] = table.weights[k];
    }
  }
  return made;
}

double square_sum(const Points& points) {
  return std::transform_reduce(points.begin(), points.end(), 0.0, std::plus<>(),
                               [](const glm::dvec3& p) { return glm::dot(p, p); });
}

void add_scaled(Points& to, double factor, const Points& from) {
  parallel_each(to.size(), [&](std::size_t i) { to[i] += factor * from[i]; });
}

void note_error(const Points& residual, Interpolation& result) {
  result.error = {};
  for (std::size_t i = 0; i < residual.size(); ++i) {
    const double distance = glm::length(residual[i]);
    if (distance > result.error.max || result.worst_vertex < 0) {
      result.error.max = distance;
      result.worst_vertex = static_cast<std::int64_t>(i);
    }
  }
  result.error.rms = std::sqrt(square_sum(residual) / static_cast<double>(residual.size()));
}

// Least squares of B d = V0 - B V0, from d = 0, so that d has no part that B takes to 0.
// Source: Hestenes & Stiefel, "Methods of conjugate gradients for solving linear systems", 1952.
void solve_least_squares(const StencilTable& masks, std::span<const glm::dvec3> given,
                         double tolerance, Interpolation& result) {
  const StencilTable back = transposed(masks.view());
  const RawVector<glm::dvec3> initial = initial_residual(SummedView(masks.view()), given);
  Points residual(initial.begin(), initial.end()), gradient(given.size()), image(given.size());
  result.displacement.assign(given.size(), glm::dvec3(0.0));
  result.worst_vertex = -1;
  note_error(residual, result);
  apply(back.view(), residual, gradient);
  Points direction = gradient;
  double length = square_sum(gradient);
  for (int step = 0; step < kGradientSteps && result.error.max > kStopMargin * tolerance; ++step) {
    check_stop();
    if (length <= kNoGradient * kNoGradient * square_sum(residual)) break;
    apply(masks.view(), direction, image);
    const double factor = length / square_sum(image);
    add_scaled(result.displacement, factor, direction);
    add_scaled(residual, -factor, image);
    ++result.iterations;
    note_error(residual, result);
    result.history.push_back(result.error);
    apply(back.view(), residual, gradient);
    const double next = square_sum(gradient), kept = next / length;
    length = next;
    parallel_each(direction.size(),
                  [&](std::size_t i) { direction[i] = gradient[i] + kept * direction[i]; });
  }
  result.converged = result.error.max <= tolerance;
  if (result.converged) result.stop_reason = StopReason::Converged;
}

// In the place of a cage that the iteration did not find.
void take_least_squares(FittedMesh& cage, const FittedMesh& fitted, PrimalScheme scheme) {
  Fit& fit = cage.fit;
  const UsedPart used = used_part(cage.mesh, fit.prepared);
  PrimalSplit split(used.mesh, {scheme, cage.options.sharp, used.prepared->topology.get()});
  split.refine(1);
  Points given(used.vertices.size());
  for (std::size_t v = 0; v < given.size(); ++v)
    given[v] = fit.placement.to_unit(fitted.points()[used.vertices[v]]);
  solve_least_squares(primal_limit_masks(split), given, cage.options.tolerance, fit.interpolation);
  for (std::size_t v = 0; v < given.size(); ++v)
    fit.cage.positions[used.vertices[v]] =
        fitted.points()[used.vertices[v]] +
        fit.placement.diagonal * fit.interpolation.displacement[v];
  fit.interpolation.worst_vertex = used.vertices[fit.interpolation.worst_vertex];
}

}  // namespace

FittedMesh cage_in_scheme(const FittedMesh& fitted, Scheme scheme, Backend& backend,
                          const Callbacks& callbacks) {
  FittedMesh cage;
  static_cast<MeshToFit&>(cage) = fitted;
  cage.warnings.clear();
  cage.rest_positions = fitted.rest_positions;
  FitOptions& options = cage.options;
  options.method = InterpolationMethod::Progressive;
  options.scheme = scheme;
  options.weights = Weights::DooSabin;
  options.solver = Solver::Chebyshev;  // the only one for meshes of all kinds
  options.within = 0.0;
  FitOptions fitting = options;
  fitting.prepared = fitted.fit.prepared;
  fitting.callbacks = callbacks;
  cage.fit = fit_through(cage.mesh, fitted.fit.points, backend, fitting);
  const auto primal = primal_scheme(scheme);
  if (!cage.fit.interpolation.converged && primal)
    backend.run_on_host([&] { take_least_squares(cage, fitted, *primal); });
  return cage;
}

std::optional<Warning> cage_warning(const FittedMesh& cage, std::string_view name) {
  const Interpolation& result = cage.fit.interpolation;
  if (result.converged) return std::nullopt;
  const std::int64_t vertex = cage.source_vertices.empty()
                                  ? result.worst_vertex
                                  : cage.source_vertices[result.worst_vertex];
  return Warning{
      "not-converged",
      formatted("{}: the control cage's surface is off by {} of the diagonal at most, at "
                "vertex {}, {} on average, more than the tolerance of {}: {} has none "
                "through these vertices, as can be where three faces meet at every one; "
                "--cage-scheme surface writes a cage that has",
                name, short_number(result.error.max), vertex, short_number(result.error.rms),
                short_number(cage.options.tolerance), word_of(kSchemeWords, cage.options.scheme)),
      1, vertex};
}

}  // namespace planish
