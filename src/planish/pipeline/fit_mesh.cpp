#include "planish/pipeline/fit_mesh.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "planish/core/error.h"
#include "planish/core/formatted.h"
#include "planish/core/host_scope.h"
#include "planish/core/version.h"
#include "planish/mesh/check.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/pipeline/bend_least.h"
#include "planish/pipeline/choose_fit.h"
#include "planish/pipeline/mesh_warnings.h"
#include "planish/pipeline/option_words.h"
#include "planish/pipeline/ready_fit.h"

namespace planish {
namespace {

// Share of the time when the mesh is checked and repaired.
constexpr double kMadeReady = 0.15;
// Of the faces, so many must be joined to be worth a second fit.
constexpr double kWorthPairing = 0.05;
// Of that, before what is sharp is found, and where triangles may be joined.
constexpr double kMended = 0.15, kOneReady = 0.4, kLookedHalved = 0.5;

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
  return level_one_quality ? &*level_one_quality : nullptr;
}

std::string FittedMesh::creases() const {
  return split_normals ? "normals" : creases_text(uses_tags, finds_features, crease_degrees);
}

FitFigures FittedMesh::figures() const {
  FitFigures figures{.method = options.method,
                     .scheme = options.scheme,
                     .weights = options.weights,
                     .solver = options.solver,
                     .boundary = options.sharp.boundary,
                     .polish_steps = options.polish_steps,
                     .tolerance = options.tolerance,
                     .creases = creases(),
                     .repairs = repairs,
                     .weld = weld,
                     .choice = choice,
                     .density = density,
                     .found_edges = std::ssize(found.edges),
                     .rounded_edges = rounded_count,
                     .separated_edges = std::ssize(separated_edges),
                     .joined = paired_count,
                     .added = std::ssize(added_vertices),
                     .welded = welded_count,
                     .sharp_edges = fit.sharp_edge_count,
                     .corners = fit.corner_count,
                     .changed_faces = changed_faces,
                     .within = fit.within,
                     .fair = fit.fair,
                     .interpolation = {},
                     .spectral_bound = fit.spectral_bound};
  const Interpolation& solved = fit.interpolation;
  Interpolation& result = figures.interpolation;
  result.converged = solved.converged;
  result.stop_reason = solved.stop_reason;
  result.iterations = solved.iterations;
  result.error = solved.error;
  result.worst_vertex = solved.worst_vertex;
  result.history = solved.history;
  result.upload_milliseconds = solved.upload_milliseconds;
  return figures;
}

namespace {

ReadyFit prepare_one(PolygonMesh mesh, std::string_view name, const MeshFitOptions& options,
                     std::vector<std::uint8_t> may_join = {}) {
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
  ready.may_join = std::move(may_join);
  Preparation preparation = preparation_of(options, result.options.method, ready.may_join);
  const bool is_chosen = ready.chooses_method && options.chooses_creases &&
                         !options.crease_degrees && result.uses_tags && mesh.creases.empty() &&
                         mesh.corners.empty();
  result.finds_features = preparation.finds_features |= is_chosen;
  result.options.keeps_planes = result.finds_features;
  preparation.features_done = [&](double part) {
    options.fit.callbacks.report("check", std::lerp(kMended, kOneReady, part));
  };
  const WarningList warnings(result.warnings, options.fit.callbacks);
  try {
    ReadyMesh made = make_ready(std::move(mesh), preparation);
    take(result, std::move(made), name, warnings);
  } catch (const Error& error) {
    if (error.code() == ErrorCode::UnusableMesh) require_usable(mesh, name);
    throw;
  }
  if (!result.options.prepared) require_usable(result.mesh, name);
  return ready;
}

// The same with triangles joined; null where hardly any are. `given`: the mesh that `ready` was
// made of, where more was done to it than can be done before.
std::shared_ptr<ReadyFit> prepare_paired(const ReadyFit& ready, std::optional<PolygonMesh> given,
                                         std::vector<std::uint8_t> may_join) {
  MeshFitOptions pairing = ready.options;
  pairing.quads = QuadChoice::On;
  pairing.fit.callbacks = {.cancelled = pairing.fit.callbacks.cancelled};
  const auto is_worth_it = [&](std::int64_t pairs) {
    return static_cast<double>(2 * pairs) > kWorthPairing * ready.fitted.mesh.face_count();
  };
  if (given) {
    auto paired = std::make_shared<ReadyFit>(
        prepare_one(std::move(*given), ready.name, pairing, std::move(may_join)));
    return is_worth_it(paired->fitted.paired_count) ? std::move(paired) : nullptr;
  }
  ReadyMesh made = ready_again(ready.fitted);
  if (!pair_up(made, ready.options.crease_degrees, may_join) || !is_worth_it(made.paired_count))
    return nullptr;
  auto paired = std::make_shared<ReadyFit>();
  paired->name = ready.name;
  paired->chooses_method = ready.chooses_method;
  FittedMesh& result = paired->fitted = without_fit(ready.fitted);
  result.pairs_triangles = true;
  take(result, std::move(made), ready.name, {result.warnings, pairing.fit.callbacks});
  if (!result.options.prepared) require_usable(result.mesh, ready.name);
  paired->options = std::move(pairing);
  paired->may_join = std::move(may_join);
  return paired;
}

}  // namespace

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

ReadyFit cage_fit(const ReadyFit& ready) {
  ReadyFit cage;
  cage.name = ready.name;
  cage.options = ready.options;
  if (cage.options.refine == RefineChoice::Auto) cage.options.refine = RefineChoice::Off;
  cage.fitted = ready.fitted;
  if (!ready.chooses_method) return cage;
  cage.options.method = InterpolationMethod::Progressive;
  cage.fitted.options.method = InterpolationMethod::Progressive;
  cage.fitted.choice.emplace().reason =
      "progressive: the control cage has the mesh's faces, as that of --interpolation fair does "
      "not";
  return cage;
}

bool has_own_cage(const FittedMesh& fitted) {
  if (!fitted.choice) return true;
  const bool is_named = fitted.choice->reason.empty();
  return (is_named || fitted.options.method == InterpolationMethod::Progressive) &&
         !fitted.choice->has_other_faces();
}

namespace {

bool has_triangles(const PolygonMesh& mesh) {
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    if (mesh.face_size(f) == 3) return true;
  return false;
}

}  // namespace

ReadyFit prepare_fit(PolygonMesh mesh, std::string_view name, const MeshFitOptions& options) {
  const HostScope host(options.fit.callbacks);
  const auto report = [&](double fraction) { options.fit.callbacks.report("check", fraction); };
  report(0);
  const bool may_pair = options.quads == QuadChoice::Auto &&
                        options.fit.scheme == Scheme::DooSabin && has_triangles(mesh);
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
    ready.looks = look_halved_by_parts(ready.fitted.mesh, *ready.fitted.options.prepared,
                                       options.crease_degrees);
    const auto are_all = [&](Halves look) {
      return std::ranges::all_of(ready.looks, [&](Halves one) { return one == look; });
    };
    std::vector<std::uint8_t> may_join;
    // What does not look like halves is worth a try where that costs little.
    const bool is_large = density.vertex_count >= kDenseVertices;
    if (is_large && !are_all(Halves::Maybe) && !are_all(Halves::Plain))
      for (const std::int32_t part : mesh_parts(ready.fitted.mesh).of_faces(ready.fitted.mesh))
        may_join.push_back(ready.looks[part] != Halves::No ? 1 : 0);
    if (!is_large || !are_all(Halves::No)) {
      report(kLookedHalved);
      ready.is_plainly_halved = are_all(Halves::Plain);
      ready.paired = prepare_paired(ready, std::move(given), std::move(may_join));
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
  if (within == 0.0) return choose_fit(std::move(ready), backend);
  const Callbacks caller = ready.options.fit.callbacks;
  const HostScope host(caller);
  set_exact(ready, share_of(caller, 0, kChosen));
  FittedMesh fitted = choose_fit(std::move(ready), backend);
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
