#include "planish/pipeline/fit_best.h"

#include <functional>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

#include "planish/core/formatted.h"
#include "planish/core/host_scope.h"
#include "planish/core/number_text.h"
#include "planish/mesh/convex_faces.h"
#include "planish/mesh/cusp_corners.h"
#include "planish/mesh/folded_edges.h"
#include "planish/mesh/mesh_density.h"
#include "planish/mesh/prepared_mesh.h"
#include "planish/surface/block_quality.h"

namespace planish {

namespace {

// A fit that is not given out yet.
struct Candidate {
  Fit fit;
  SurfaceQuality quality;
  std::vector<Warning> warnings;
  bool is_kept = true;  // else only figures are there

  // Gives back the memory of a fit that is hardly taken any more.
  void drop() {
    fit.cage = {};
    fit.features.reset();
    fit.interpolation.displacement = {};
    is_kept = false;
  }
  [[nodiscard]] bool folds() const { return quality.folded_area_elsewhere >= kSoundFoldedArea; }
  [[nodiscard]] bool is_sound() const { return fit.interpolation.converged && !folds(); }
};

// Of the time of a candidate, that of its fit.
constexpr double kCandidateFitted = 0.75;
// Of the time, the surface that is sharp where that was found.
constexpr double kSharpMeasured = 0.5;
// Of the time of two candidates, that of the first and of both: a look at level 2 may come.
constexpr double kFirstMeasured = 0.3, kBothMeasured = 0.9;

SurfaceQuality measured_quality(const PolygonMesh& mesh, const Fit& fit, const FitOptions& options,
                                const Callbacks& callbacks, int level = 1) {
  EvaluateOptions evaluation;
  evaluation.weights = options.weights;
  evaluation.sharp = options.sharp;
  const auto surface = fitted_surface(mesh, fit, evaluation);
  return surface_quality(*surface->level(level), mesh,
                         folded_edges(mesh, *fit.prepared->topology).is_beside, callbacks);
}

Candidate candidate(const PolygonMesh& mesh, Backend& backend, FitOptions options) {
  Candidate result;
  const Callbacks whole = options.callbacks;
  options.callbacks = share_of(whole, 0, kCandidateFitted);
  options.method = InterpolationMethod::Progressive;
  options.callbacks.warning = [&](const Warning& warning) { result.warnings.push_back(warning); };
  result.fit = fit(mesh, backend, options);
  result.quality =
      measured_quality(mesh, result.fit, options, share_of(whole, kCandidateFitted, 1));
  return result;
}

Candidate fair_candidate(FairMesh& made, Backend& backend, FitOptions options, BestFit& best) {
  Candidate result;
  const Callbacks whole = options.callbacks;
  options.callbacks = share_of(whole, 0, kCandidateFitted);
  options.method = InterpolationMethod::Fair;
  options.prepared = made.prepared;
  options.callbacks.warning = [&](const Warning& warning) { result.warnings.push_back(warning); };
  if (made.found) {
    CreasedFit creased = fit_with_found_creases(made.mesh, *made.found, backend, options);
    result.fit = std::move(creased.fit);
    best.smoothed_vertices = std::move(creased.smoothed_vertices);
  } else {
    result.fit = fit(made.mesh, backend, options);
  }
  result.quality =
      measured_quality(made.mesh, result.fit, options, share_of(whole, kCandidateFitted, 1));
  return result;
}

// `folded_at_two`: of the progressive surface at level 2, which tells needles and hubs that look
// whole between the places of level 1.
void choose_by_normals(const Candidate& progressive, const Candidate& fair,
                       const std::function<double()>& folded_at_two, BestFit& best) {
  const double rms = progressive.quality.rms_normal_deviation;
  const double fair_rms = fair.quality.rms_normal_deviation;
  if (rms >= kClearlyBetter * fair_rms) {
    best.reason = "fair: progressive's normals are not clearly nearer to the faces'";
    return;
  }
  const double folded = folded_at_two();
  if (folded >= kSoundFoldedArea) {
    best.reason = formatted("fair: progressive folds {} of the area at level 2", percent(folded));
    return;
  }
  best.method = InterpolationMethod::Progressive;
  best.reason =
      "progressive: it does not fold, and its normals are clearly nearer to the faces' than fair's";
}

// Takes the fair surface, or leaves the progressive one.
void choose(const Candidate& progressive, const Candidate& fair,
            const std::function<double()>& folded_at_two, BestFit& best) {
  const double folded = progressive.quality.folded_area_elsewhere;
  const double fair_folded = fair.quality.folded_area_elsewhere;
  best.method = InterpolationMethod::Fair;
  if (!progressive.fit.interpolation.converged) {
    best.reason = "fair: progressive did not converge";
  } else if (!fair.fit.interpolation.converged) {
    best.method = InterpolationMethod::Progressive;
    best.reason = "progressive: fair misses the tolerance";
  } else if (fair.folds() && fair_folded > folded) {
    best.method = InterpolationMethod::Progressive;
    best.reason = formatted("progressive: it folds {} of the area, fair {}", percent(folded),
                            percent(fair_folded));
  } else if (progressive.folds()) {
    best.reason = formatted("fair: progressive folds {} of the area, fair {}", percent(folded),
                            percent(fair_folded));
  } else {
    choose_by_normals(progressive, fair, folded_at_two, best);
  }
}

void give_out(Candidate&& taken, BestFit& best, const Callbacks& callbacks) {
  best.fit = std::move(taken.fit);
  for (const Warning& warning : taken.warnings) callbacks.warn(warning);
}

}  // namespace

namespace {

FairMesh fair_mesh_of(const PolygonMesh& mesh, const std::function<FairMesh()>& make) {
  return make ? make() : FairMesh{with_cusp_corners(with_convex_faces(mesh).mesh), nullptr, {}};
}

BestFit best_of(const PolygonMesh& mesh, Backend& backend, const FitOptions& options,
                const std::function<FairMesh()>& make_fair_mesh, bool are_found_sharp) {
  BestFit best;
  FitOptions of_candidate = options;
  Callbacks caller = options.callbacks;
  FairMesh made;
  std::optional<Candidate> fair;
  const auto make_fair = [&] {
    made = fair_mesh_of(mesh, make_fair_mesh);
    fair = fair_candidate(made, backend, of_candidate, best);
    best.fair = fair->quality;
  };
  if (are_found_sharp) {
    of_candidate.callbacks = share_of(caller, 0, kSharpMeasured);
    make_fair();
    if (fair->is_sound()) {
      best.method = InterpolationMethod::Fair;
      best.fair_mesh = std::move(made.mesh);
      best.reason = "fair: it does not fold beside what is sharp";
      give_out(*std::move(fair), best, options.callbacks);
      return best;
    }
    caller = share_of(caller, kSharpMeasured, 1);
  }
  of_candidate.callbacks = share_of(caller, 0, kFirstMeasured);
  Candidate progressive = candidate(mesh, backend, of_candidate);
  best.progressive = progressive.quality;
  const auto folded_at_two = [&] {
    return measured_quality(mesh, progressive.fit, options, share_of(caller, kBothMeasured, 1), 2)
        .folded_area_elsewhere;
  };
  const bool is_close =
      progressive.is_sound() && progressive.quality.rms_normal_deviation < kCloseDegrees;
  // The places of level 1 of a dense mesh are near enough to each other.
  if (is_close && (mesh_density(mesh, *progressive.fit.prepared->topology).is_dense() ||
                   folded_at_two() < kSoundFoldedArea)) {
    best.reason = "progressive: it does not fold, and its normals are near the faces'";
    best.smoothed_vertices.clear();
    give_out(std::move(progressive), best, caller);
    return best;
  }
  // It is taken only where the fair one is worse still, and made again then.
  if (!progressive.is_sound()) progressive.drop();
  of_candidate.callbacks = share_of(caller, kFirstMeasured, kBothMeasured);
  if (!fair) make_fair();
  choose(progressive, *fair, folded_at_two, best);
  const bool is_fair = best.method == InterpolationMethod::Fair;
  if (!is_fair && !progressive.is_kept) {
    fair.reset();
    of_candidate.callbacks = share_of(caller, kBothMeasured, 1);
    progressive = candidate(mesh, backend, of_candidate);
  }
  give_out(std::move(is_fair ? *fair : progressive), best, caller);
  if (is_fair) {
    best.fair_mesh = std::move(made.mesh);
  } else {
    best.smoothed_vertices.clear();
  }
  return best;
}

}  // namespace

BestFit fit_best(const PolygonMesh& mesh, Backend& backend, const FitOptions& options,
                 const std::function<FairMesh()>& make_fair_mesh, bool are_found_sharp) {
  const HostScope host(options.callbacks);
  BestFit best;
  backend.run_on_host(
      [&] { best = best_of(mesh, backend, options, make_fair_mesh, are_found_sharp); });
  options.callbacks.report("choose", 1);
  return best;
}

}  // namespace planish
