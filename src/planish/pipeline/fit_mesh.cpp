#include "planish/pipeline/fit_mesh.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <utility>

#include "planish/core/counted.h"
#include "planish/core/error.h"
#include "planish/core/formatted.h"
#include "planish/core/host_scope.h"
#include "planish/core/number_text.h"
#include "planish/core/version.h"
#include "planish/mesh/check.h"
#include "planish/mesh/folded_edges.h"
#include "planish/pipeline/bend_least.h"
#include "planish/pipeline/found_creases.h"
#include "planish/pipeline/make_ready.h"
#include "planish/pipeline/mesh_warnings.h"
#include "planish/pipeline/option_words.h"
#include "planish/surface/block_quality.h"

namespace planish {
namespace {

// Share of the time when the mesh is checked and repaired.
constexpr double kMadeReady = 0.15;
// Of the faces, so many must be joined to be worth a second fit.
constexpr double kWorthPairing = 0.05;
// Degrees by which faces turn at their edges: where it is less, facets of a fine surface through
// the given vertices are no more visible than those that are written.
constexpr double kWorthRefining = 1;
// Of the bending without them, so much is left at most where added vertices are worth their rows.
constexpr double kRefinedBending = 0.9;
// Of the time, what comes before vertices are added, and of the rest, the fit through these.
constexpr double kFittedOnce = 0.5, kRefinedFitted = 0.6;
// Of that, before what is sharp is found, and where triangles may be joined.
constexpr double kMended = 0.15, kOneReady = 0.4, kLookedHalved = 0.5;

Preparation preparation_of(const MeshFitOptions& options, InterpolationMethod method) {
  return {.repairs = options.repairs,
          .uses_tags = options.fit.sharp.use_tags,
          .finds_features = options.finds_features,
          .crease_degrees = options.crease_degrees,
          .method = method,
          .weld = options.weld,
          .smoothed_vertices = {},
          .pairs_triangles = options.quads == QuadChoice::On,
          .stands_alone = options.stands_alone};
}

// Every warning once, to the caller and into the result.
class WarningList {
 public:
  WarningList(std::vector<Warning>& list, const Callbacks& caller) : list_(list), caller_(caller) {}
  void add(const Warning& warning) const {
    const auto same = [&](const Warning& other) {
      return other.code == warning.code && other.message == warning.message;
    };
    if (std::ranges::any_of(list_, same)) return;
    list_.push_back(warning);
    caller_.warn(warning);
  }

 private:
  std::vector<Warning>& list_;
  const Callbacks& caller_;
};

void take(FittedMesh& result, ReadyMesh&& ready, std::string_view name,
          const WarningList& warnings) {
  for (Warning change : ready.changes) {
    change.message = std::string(name) + ": " + change.message;
    warnings.add(change);
  }
  result.mesh = std::move(ready.mesh);
  result.welded_count = ready.welded_count;
  result.paired_count = ready.paired_count;
  result.changed_faces = std::move(ready.changed_faces);
  result.separated_edges = std::move(ready.separated_edges);
  result.source_vertices = std::move(ready.source_vertices);
  result.source_faces = std::move(ready.source_faces);
  result.options.prepared = std::move(ready.prepared);
}

// The mesh that take() took. What was said of it was said.
ReadyMesh ready_again(const FittedMesh& fitted) {
  ReadyMesh ready;
  ready.mesh = fitted.mesh;
  ready.welded_count = fitted.welded_count;
  ready.paired_count = fitted.paired_count;
  ready.changed_faces = fitted.changed_faces;
  ready.separated_edges = fitted.separated_edges;
  ready.source_vertices = fitted.source_vertices;
  ready.source_faces = fitted.source_faces;
  ready.prepared = fitted.options.prepared;
  return ready;
}

double sum_of(const FitTiming& timing) {
  return timing.check + timing.topology + timing.stencils + timing.upload + timing.solve;
}

// What is sharp though nobody asked for it.
std::string features_text(const ReadyFit& ready) {
  if (!ready.found || ready.options.finds_features || ready.options.crease_degrees) return {};
  // Some may have been taken back.
  const auto edges = std::ssize(ready.fitted.mesh.creases);
  if (edges > 0)
    return "; " + counted(edges, "edge") +
           " kept sharp, where two surfaces meet (--creases use rounds " +
           (edges == 1 ? "it" : "them") + ")";
  return ready.fitted.mesh.corners.empty()
             ? ""
             : "; corners of its outline and tips are kept (--creases use rounds them)";
}

void choose_method(ReadyFit& ready, Backend& backend, const WarningList& warnings) {
  const auto began = std::chrono::steady_clock::now();
  FittedMesh& result = ready.fitted;
  ReadyMesh fair;
  const auto make_fair_mesh = [&] {
    fair = ready.given ? make_ready(std::move(*ready.given),
                                    preparation_of(ready.options, InterpolationMethod::Fair))
                       : ready_again(result);
    if (!ready.given) {
      fair.found = ready.found;
      if (ready.options.repairs) make_fair(fair);
    }
    return FairMesh{std::move(fair.mesh), fair.prepared, std::move(fair.found)};
  };
  BestFit best = fit_best(result.mesh, backend, result.options, make_fair_mesh,
                          !ready.given && ready.found && !ready.found->creases.empty());
  result.reason = MethodReason{best.reason, best.progressive, best.fair};
  result.options.method = best.method;
  result.smoothed_vertices = std::move(best.smoothed_vertices);
  if (best.fair_mesh) {
    fair.mesh = std::move(*best.fair_mesh);
    take(result, std::move(fair), ready.name, warnings);
  }
  result.reason->text += features_text(ready);
  result.fit = std::move(best.fit);
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - began;
  result.choose_milliseconds = took.count() - sum_of(result.fit.timing);
}

}  // namespace

EvaluateOptions FittedMesh::evaluate_options(int level) const {
  return {.level = level,
          .scheme = options.scheme,
          .weights = options.weights,
          .sharp = options.sharp,
          .rest_positions = rest_positions.empty() ? mesh.positions : rest_positions,
          .features = fit.features,
          .prepared = fit.prepared};
}

const SurfaceQuality* FittedMesh::chosen_quality() const {
  if (fit.within && fit.within->left) return &*fit.within->left;
  if (!reason) return nullptr;
  const bool is_fair = options.method == InterpolationMethod::Fair;
  const auto& measured = is_fair ? reason->fair : reason->progressive;
  return measured ? &*measured : nullptr;
}

std::string FittedMesh::creases() const {
  return split_normals ? "normals" : creases_text(uses_tags, finds_features, crease_degrees);
}

namespace {

ReadyFit prepare_one(PolygonMesh mesh, std::string_view name, const MeshFitOptions& options) {
  // One after another: where copying the options fails, GCC 12 frees the name of a list of both
  // twice.
  ReadyFit ready;
  ready.name = name;
  ready.options = options;
  FittedMesh& result = ready.fitted;
  result.options = options.fit;
  result.options.callbacks = {};  // the caller's end with the call
  result.options.method = options.method.value_or(InterpolationMethod::Progressive);
  result.repairs = options.repairs;
  result.crease_degrees = options.crease_degrees;
  result.weld = options.weld;
  result.pairs_triangles = options.quads == QuadChoice::On;
  result.uses_tags = options.fit.sharp.use_tags;
  result.options.sharp.use_tags = true;  // what make_ready() left has none but those that count
  if (!options.method && options.fit.scheme == Scheme::DooSabin) {
    ready.chooses_method = true;
    // Creases were found on faces that the fair method may cut.
    if (options.crease_degrees) ready.given = mesh;
  }
  Preparation preparation = preparation_of(options, result.options.method);
  const bool is_chosen = ready.chooses_method && options.chooses_creases &&
                         !options.crease_degrees && result.uses_tags && mesh.creases.empty() &&
                         mesh.corners.empty();
  result.finds_features = preparation.finds_features |= is_chosen;
  preparation.features_done = [&](double part) {
    options.fit.callbacks.report("check", std::lerp(kMended, kOneReady, part));
  };
  const WarningList warnings(result.warnings, options.fit.callbacks);
  try {
    ReadyMesh made = make_ready(std::move(mesh), preparation);
    ready.found = std::move(made.found);
    take(result, std::move(made), name, warnings);
  } catch (const Error& error) {
    if (error.code() == ErrorCode::UnusableMesh) require_usable(mesh, name);
    throw;
  }
  if (!result.options.prepared) require_usable(result.mesh, name);
  return ready;
}

FittedMesh fit_one(ReadyFit ready, Backend& backend) {
  FittedMesh& result = ready.fitted;
  const Callbacks& caller = ready.options.fit.callbacks;
  const HostScope host(caller);
  const WarningList warnings(result.warnings, caller);
  result.options.callbacks = caller;
  result.options.callbacks.warning = [&](const Warning& warning) { warnings.add(warning); };
  try {
    if (ready.chooses_method) {
      choose_method(ready, backend, warnings);
    } else if (ready.found && result.options.method == InterpolationMethod::Fair) {
      CreasedFit creased =
          fit_with_found_creases(result.mesh, *ready.found, backend, result.options);
      result.smoothed_vertices = std::move(creased.smoothed_vertices);
      result.fit = std::move(creased.fit);
    } else {
      result.fit = fit(result.mesh, backend, result.options);
    }
  } catch (const Error& error) {
    // fit() knows no name: say it again with the name.
    if (error.code() != ErrorCode::UnusableMesh) throw;
    throw Error(error.code(), ready.name + ": " + error.what(), error.element());
  }
  result.options.callbacks = {};
  return std::move(ready.fitted);
}

SurfaceQuality quality_of(const FittedMesh& fitted, int level, const Callbacks& callbacks) {
  const auto surface = fitted_surface(fitted.mesh, fitted.fit, fitted.evaluate_options());
  const FoldedEdges folds = folded_edges(fitted.mesh, *fitted.fit.prepared->topology);
  return surface_quality(*surface->level(level), fitted.mesh, folds.is_beside, callbacks);
}

BendingFigures figures_of(const FittedMesh& fitted, const Callbacks& callbacks, int level = 2) {
  const SurfaceQuality quality = quality_of(fitted, level, callbacks);
  return {fitted.fit.interpolation.converged, quality.bending, quality.folded_area_elsewhere};
}

// Why added vertices are no gain; empty: they are.
std::string refusal_to_refine(const BendingFigures& given, const BendingFigures& refined) {
  if (!refined.converged) return "none added: the surface through them misses the tolerance";
  if (refined.folded_area >= kSoundFoldedArea && refined.folded_area > given.folded_area)
    return formatted("none added: the surface through them folds {} % of the area",
                     short_number(100 * refined.folded_area));
  if (refined.bending >= kRefinedBending * given.bending)
    return "none added: the surface bends hardly less with them";
  return {};
}

bool is_whole(const FittedMesh& fitted, const Callbacks& callbacks) {
  if (!fitted.fit.interpolation.converged) return false;
  const SurfaceQuality* const known = fitted.chosen_quality();
  const double folded = known != nullptr ? known->folded_area_elsewhere
                                         : quality_of(fitted, 1, callbacks).folded_area_elsewhere;
  return folded < kSoundFoldedArea;
}

bool is_fair(const FittedMesh& fitted) {
  return fitted.options.method == InterpolationMethod::Fair;
}

// Makes of a fit one through further vertices, too, where that bends less than the best without
// them, as `given` tells, and says why or why not; empty where nothing is to be said.
std::optional<RefineReason> refine_into(FittedMesh& fitted, const MeshFitOptions& options,
                                        Backend& backend,
                                        const std::optional<BendingFigures>& given,
                                        const Callbacks& callbacks) {
  const auto began = std::chrono::steady_clock::now();
  std::optional<RefinedMesh> made = refine_mesh(fitted.mesh, *fitted.fit.prepared);
  if (!made) return std::nullopt;
  FittedMesh refined;
  refined.options = fitted.options;
  refined.options.prepared = nullptr;
  refined.options.callbacks = share_of(callbacks, 0, kRefinedFitted);
  refined.options.callbacks.warning = [&](const Warning& warning) {
    refined.warnings.push_back(warning);
  };
  refined.fit = fit(made->mesh, backend, refined.options);
  refined.options.callbacks = {};
  refined.mesh = std::move(made->mesh);
  RefineReason reason;
  if (options.refine == RefineChoice::Auto) {
    reason.given = given ? *given : figures_of(fitted, share_of(callbacks, kRefinedFitted, 0.8));
    reason.refined = figures_of(refined, share_of(callbacks, 0.8, 1), 1);
    reason.text = refusal_to_refine(*reason.given, *reason.refined);
    if (!reason.text.empty()) return reason;
    reason.text = formatted(
        "{} added between those of uneven triangles: the surface bends less "
        "(--refine off adds none)",
        counted(std::ssize(made->added), "vertex"));
  }
  const double chosen = fitted.choose_milliseconds + sum_of(fitted.fit.timing);
  fitted.mesh = std::move(refined.mesh);
  fitted.fit = std::move(refined.fit);
  fitted.added_vertices = std::move(made->added);
  fitted.density.is_refined = true;
  std::vector<std::int32_t>& sources = fitted.source_vertices;
  if (sources.empty()) {
    sources.resize(fitted.mesh.positions.size() - fitted.added_vertices.size());
    std::iota(sources.begin(), sources.end(), 0);
  }
  sources.resize(fitted.mesh.positions.size(), -1);
  if (!fitted.source_faces.empty())
    for (std::int32_t& face : made->source_faces) face = fitted.source_faces[face];
  fitted.source_faces = std::move(made->source_faces);
  const WarningList warnings(fitted.warnings, callbacks);
  for (const Warning& warning : refined.warnings) warnings.add(warning);
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - began;
  fitted.choose_milliseconds = chosen + took.count() - sum_of(fitted.fit.timing);
  return reason;
}

// The fit of quads, and that of triangles, with added vertices, too, unless they are plainly halves
// and the quads do not fold: the best one is given out, with its warnings alone.
FittedMesh fit_both(ReadyFit ready, Backend& backend) {
  const MeshFitOptions options = ready.options;
  const bool may_add = may_refine(ready);
  const bool is_plain = ready.is_plainly_halved;
  // Of the time, the first fit, and both.
  const double first = is_plain ? 0.9 : 0.45, both = is_plain ? 0.95 : 0.9;
  const Callbacks caller = share_of(options.fit.callbacks, 0, kFittedOnce);
  ReadyFit paired = std::move(*std::exchange(ready.paired, nullptr));
  paired.options.fit.callbacks = share_of(caller, 0, first);
  ready.options.fit.callbacks = share_of(caller, first, both);
  for (ReadyFit* one : {&ready, &paired}) one->options.fit.callbacks.warning = {};
  const std::size_t told = ready.fitted.warnings.size();
  paired.fitted.warnings = ready.fitted.warnings;
  paired.fitted.reason = ready.fitted.reason;
  const auto began = std::chrono::steady_clock::now();
  auto& prepared = ready.fitted.options.prepared;
  // Mostly that is of no use any more.
  if (is_plain) prepared.reset();
  FittedMesh quads = fit_one(std::move(paired), backend);
  if (is_plain && is_whole(quads, share_of(caller, first, both))) {
    quads.quad_reason = {
        .are_better = true,
        .triangles = {},
        .quads = {},
        .text = "triangles joined to quads, whose halves they are (--quads off leaves them)"};
    for (std::size_t i = told; i < quads.warnings.size(); ++i) caller.warn(quads.warnings[i]);
    return quads;
  }
  if (!prepared) prepared = prepare_mesh(ready.fitted.mesh, ready.name);
  FittedMesh triangles = fit_one(std::move(ready), backend);
  const double one_measured = (1 + both) / 2;
  const BendingFigures of_triangles = figures_of(triangles, share_of(caller, both, one_measured));
  const BendingFigures of_quads = figures_of(quads, share_of(caller, one_measured, 1));
  QuadReason reason = choose_quads(of_triangles, of_quads);
  std::optional<RefineReason> refining;
  if (may_add && is_fair(triangles)) {
    Callbacks rest = share_of(options.fit.callbacks, kFittedOnce, 1);
    rest.warning = {};
    refining =
        refine_into(triangles, options, backend, reason.are_better ? of_quads : of_triangles, rest);
    if (reason.are_better && !triangles.added_vertices.empty()) {
      reason.are_better = false;
      reason.text = "triangles, with vertices added: the surface of quads bends more";
    }
  }
  FittedMesh& taken = reason.are_better ? quads : triangles;
  taken.quad_reason = std::move(reason);
  taken.refine_reason = std::move(refining);
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - began;
  taken.choose_milliseconds = took.count() - sum_of(taken.fit.timing);
  for (std::size_t i = told; i < taken.warnings.size(); ++i) caller.warn(taken.warnings[i]);
  return std::move(taken);
}

// The same with triangles joined; null where hardly any are. `given`: the mesh that `ready` was
// made of, where more was done to it than can be done before.
std::shared_ptr<ReadyFit> prepare_paired(const ReadyFit& ready, std::optional<PolygonMesh> given) {
  MeshFitOptions pairing = ready.options;
  pairing.quads = QuadChoice::On;
  pairing.fit.callbacks = {.cancelled = pairing.fit.callbacks.cancelled};
  const auto is_worth_it = [&](std::int64_t pairs) {
    return static_cast<double>(2 * pairs) > kWorthPairing * ready.fitted.mesh.face_count();
  };
  if (given) {
    auto paired = std::make_shared<ReadyFit>(prepare_one(std::move(*given), ready.name, pairing));
    return is_worth_it(paired->fitted.paired_count) ? std::move(paired) : nullptr;
  }
  ReadyMesh made = ready_again(ready.fitted);
  if (!pair_up(made, ready.options.crease_degrees) || !is_worth_it(made.paired_count))
    return nullptr;
  auto paired = std::make_shared<ReadyFit>();
  paired->name = ready.name;
  paired->chooses_method = ready.chooses_method;
  paired->found = ready.found;
  FittedMesh& result = paired->fitted;
  result.options = ready.fitted.options;
  result.repairs = ready.fitted.repairs;
  result.weld = ready.fitted.weld;
  result.pairs_triangles = true;
  result.uses_tags = ready.fitted.uses_tags;
  result.finds_features = ready.fitted.finds_features;
  take(result, std::move(made), ready.name, {result.warnings, pairing.fit.callbacks});
  if (!result.options.prepared) require_usable(result.mesh, ready.name);
  paired->options = std::move(pairing);
  return paired;
}

}  // namespace

bool may_refine(const ReadyFit& ready) {
  const MeshFitOptions& options = ready.options;
  const FittedMesh& mesh = ready.fitted;
  const bool is_free = options.stands_alone && options.fit.scheme == Scheme::DooSabin &&
                       options.fit.within == 0.0 && options.fit.fair_decisions == nullptr;
  if (!is_free || mesh.paired_count > 0) return false;
  if (options.refine != RefineChoice::Auto)
    return options.refine == RefineChoice::On &&
           options.method.value_or(InterpolationMethod::Fair) == InterpolationMethod::Fair;
  return !options.method && !ready.is_plainly_halved && !mesh.density.is_dense() &&
         rms_turn(mesh.mesh, *mesh.options.prepared) >= kWorthRefining;
}

void prepare_refined(ReadyFit& ready) {
  if (!may_refine(ready)) return;
  auto made = refine_mesh(ready.fitted.mesh, *ready.fitted.options.prepared);
  if (!made) return;
  ready.refined = std::make_shared<ReadyFit>();
  FittedMesh& refined = ready.refined->fitted;
  refined.options.prepared = prepare_mesh(made->mesh, ready.name);
  refined.mesh = std::move(made->mesh);
  refined.added_vertices = std::move(made->added);
  refined.density = ready.fitted.density;
  refined.density.is_refined = true;
}

ReadyFit prepare_fit(PolygonMesh mesh, std::string_view name, const MeshFitOptions& options) {
  const HostScope host(options.fit.callbacks);
  const auto report = [&](double fraction) { options.fit.callbacks.report("check", fraction); };
  report(0);
  const bool may_pair = options.quads == QuadChoice::Auto &&
                        options.fit.scheme == Scheme::DooSabin && are_mostly_triangles(mesh);
  // Creases, and what is done for fair surfaces alone, come after the pairs.
  std::optional<PolygonMesh> given;
  if (may_pair && (options.crease_degrees || options.method == InterpolationMethod::Fair))
    given = mesh;
  ReadyFit ready = prepare_one(std::move(mesh), name, options);
  const MeshDensity density =
      mesh_density(ready.fitted.mesh, *ready.fitted.options.prepared->topology);
  if (options.faces_are_given)
    if (const auto torn = torn_warning(ready.fitted, name))
      WarningList(ready.fitted.warnings, options.fit.callbacks).add(*torn);
  if (may_pair) {
    report(kOneReady);
    const Halves halves =
        look_halved(ready.fitted.mesh, *ready.fitted.options.prepared, options.crease_degrees);
    if (halves != Halves::No) {
      report(kLookedHalved);
      ready.is_plainly_halved = halves == Halves::Plain;
      ready.paired = prepare_paired(ready, std::move(given));
    }
  }
  for (ReadyFit* one : {&ready, ready.paired.get()}) {
    if (one == nullptr) continue;
    one->fitted.density = density;
  }
  report(1);
  return ready;
}

namespace {

// Of the time, all that is chosen, where vertices may be left then.
constexpr double kChosen = 0.5;

FittedMesh fit_chosen(ReadyFit ready, Backend& backend) {
  if (ready.paired) return fit_both(std::move(ready), backend);
  const MeshFitOptions options = ready.options;
  const Callbacks& caller = options.fit.callbacks;
  const bool may_add = may_refine(ready);
  if (may_add) ready.options.fit.callbacks = share_of(caller, 0, kFittedOnce);
  FittedMesh fitted = fit_one(std::move(ready), backend);
  if (may_add && is_fair(fitted))
    fitted.refine_reason =
        refine_into(fitted, options, backend, std::nullopt, share_of(caller, kFittedOnce, 1));
  return fitted;
}

// And without added vertices: where the given ones may be left, these would be left behind.
void set_exact(ReadyFit& ready, const Callbacks& callbacks) {
  ready.options.refine = RefineChoice::Off;
  ready.options.fit.within = ready.fitted.options.within = 0.0;
  ready.options.fit.callbacks = callbacks;
  if (ready.paired) set_exact(*ready.paired, callbacks);
}

// What is chosen is chosen by the surfaces through the given vertices: where they may be left, the
// chosen one bends no more for that.
FittedMesh fit_within(ReadyFit ready, Backend& backend) {
  const std::optional<double> within = ready.options.fit.within;
  if (within == 0.0) return fit_chosen(std::move(ready), backend);
  const Callbacks caller = ready.options.fit.callbacks;
  const HostScope host(caller);
  set_exact(ready, share_of(caller, 0, kChosen));
  FittedMesh fitted = fit_chosen(std::move(ready), backend);
  FitOptions leaving = fitted.options;
  leaving.within = within;
  leaving.callbacks = share_of(caller, kChosen, 1);
  const WarningList warnings(fitted.warnings, caller);
  leaving.callbacks.warning = [&](const Warning& warning) { warnings.add(warning); };
  backend.run_on_host([&] { leave_vertices(fitted.mesh, backend, leaving, fitted.fit); });
  fitted.options.within = within;
  return fitted;
}

}  // namespace

FittedMesh fit_prepared(ReadyFit ready, Backend& backend) {
  const MeshFitOptions options = ready.options;
  const Callbacks& caller = options.fit.callbacks;
  const std::string name = ready.name;
  FittedMesh fitted = fit_within(std::move(ready), backend);
  const WarningList warnings(fitted.warnings, caller);
  for (const Warning& warning : mesh_warnings(fitted, name, options.faces_are_given))
    warnings.add(warning);
  return fitted;
}

FittedMesh fit_mesh(PolygonMesh mesh, std::string_view name, Backend& backend,
                    const MeshFitOptions& options) {
  const HostScope host(options.fit.callbacks);
  FittedMesh result;
  backend.run_on_host([&] {
    MeshFitOptions preparing = options;
    preparing.fit.callbacks = share_of(options.fit.callbacks, 0, kMadeReady);
    ReadyFit ready = prepare_fit(std::move(mesh), name, preparing);
    ready.options.fit.callbacks = share_of(options.fit.callbacks, kMadeReady, 1);
    result = fit_prepared(std::move(ready), backend);
  });
  options.fit.callbacks.report("fit", 1);
  return result;
}

Precision precision_for(double tolerance) {
  // Float reaches 1e-9 of the diagonal at best; one digit is kept in hand.
  constexpr double kFloatTolerance = 1e-8;
  return tolerance < kFloatTolerance ? Precision::Double : Precision::Float;
}

FileExtras fit_extras(const FitOptions& options, std::string creases, const Interpolation& result) {
  const bool iterates = options.method == InterpolationMethod::Progressive;
  FileExtras extras = {
      {"planish", std::string(PLANISH_VERSION)},
      {"scheme", std::string(word_of(kSchemeWords, options.scheme))},
      {"method", std::string(word_of(kMethodWords, options.method))},
      {"solver", iterates ? std::string(word_of(kSolverWords, options.solver)) : "none"},
      {"boundary", std::string(word_of(kBoundaryWords, options.sharp.boundary))},
      {"creases", std::move(creases)},
      {"tolerance", options.tolerance},
      {"converged", result.converged},
      {"iterations", std::int64_t{result.iterations}},
      {"max_error", result.error.max}};
  if (options.scheme == Scheme::DooSabin)
    extras.emplace_back("weights", std::string(word_of(kWeightsWords, options.weights)));
  return extras;
}

glm::dvec3 storage_origin(const Placement& placement) {
  constexpr double kFarFromOrigin = 10.0;  // diagonals, from which float32 loses a digit and more
  const glm::dvec3& centre = placement.centre;
  const bool is_far =
      std::hypot(centre.x, centre.y, centre.z) > kFarFromOrigin * placement.diagonal;
  return is_far ? centre : glm::dvec3(0.0);
}

}  // namespace planish
