#include "planish/pipeline/fit_mesh.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/portable_math.h"
#include "planish/core/version.h"
#include "planish/fair/semi_sharp.h"
#include "planish/mend/faults.h"
#include "planish/mend/repair.h"
#include "planish/mesh/check.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/pipeline/fit_report.h"
#include "planish/pipeline/fit_steps.h"
#include "planish/pipeline/option_table.h"
#include "planish/queries/limit_surface.h"

namespace planish {
namespace {

// Of triangles in a row on one line each round takes out one.
constexpr int kFlatRounds = 8;

// Takes a mesh with other faces: of which of its own they are, and which of these changed.
void take_faces(ReadyMesh& ready, PolygonMesh&& mesh, std::vector<std::int32_t>&& source_faces,
                std::vector<std::int32_t> changed_faces) {
  std::vector<std::int32_t>& sources = ready.source_faces;
  if (!sources.empty())
    for (auto* faces : {&source_faces, &changed_faces})
      for (std::int32_t& face : *faces) face = sources[face];
  std::vector<std::int32_t>& changed = ready.changed_faces;
  changed.insert(changed.end(), changed_faces.begin(), changed_faces.end());
  std::ranges::sort(changed);
  changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
  sources = std::move(source_faces);
  ready.mesh = std::move(mesh);
  ready.prepared = prepare_if_sound(ready.mesh);
}

std::int32_t source_of(const ReadyMesh& ready, std::int32_t face) {
  return ready.source_faces.empty() ? face : ready.source_faces[face];
}

void cut_concave_faces(ReadyMesh& ready) {
  ConvexMesh convex = with_convex_faces(ready.mesh);
  if (convex.cut_faces.empty()) return;
  const std::int64_t count = std::ssize(convex.cut_faces);
  ready.changes.push_back({"concave-faces",
                           formatted("faces with corners that turn inward or lie unevenly, cut in "
                                     "parts for the fair surface: {}",
                                     count),
                           count, source_of(ready, convex.cut_faces.front())});
  take_faces(ready, std::move(convex.mesh), std::move(convex.source_faces), convex.cut_faces);
}

void take_out_flat_triangles(ReadyMesh& ready, bool adds_uvs) {
  std::int64_t count = 0;
  std::int32_t first = -1;
  for (int round = 0; ready.prepared && round < kFlatRounds; ++round) {
    UnflattenedMesh made = without_flat_triangles(ready.mesh, *ready.prepared->topology, adds_uvs);
    if (made.flat_faces.empty()) break;
    count += std::ssize(made.flat_faces);
    if (first < 0) first = source_of(ready, made.flat_faces.front());
    take_faces(ready, std::move(made.mesh), std::move(made.source_faces), made.changed_faces);
  }
  if (count > 0)
    ready.changes.push_back(
        {"flat-triangles",
         formatted("triangles whose corners lie on a line, given to the faces beside them: {}",
                   count),
         count, first});
}

// Of a mesh that may have been welded already: of which vertices of the file its own are.
PolygonMesh take_welded(WeldedMesh&& welded, std::vector<std::int32_t>& sources,
                        std::int64_t& count) {
  count += welded.welded_count;
  if (!sources.empty() && welded.welded_count > 0)
    for (std::int32_t& source : welded.source_vertices) source = sources[source];
  if (welded.welded_count > 0) sources = std::move(welded.source_vertices);
  return std::move(welded.mesh);
}

// What was said of the vertices of the welded mesh, of the file's.
void name_sources(ReadyMesh& ready, std::vector<std::int32_t>&& welded) {
  if (welded.empty()) return;
  for (auto& [a, b] : ready.separated_edges) std::tie(a, b) = std::minmax(welded[a], welded[b]);
  std::ranges::sort(ready.separated_edges);
  for (Warning& change : ready.changes) {
    const bool is_vertex = change.code.starts_with("non-manifold");
    if (is_vertex && change.first >= 0) change.first = welded[change.first];
  }
  if (ready.source_vertices.empty()) {
    ready.source_vertices = std::move(welded);
  } else {
    for (std::int32_t& source : ready.source_vertices) source = welded[source];
  }
}

}  // namespace

void keep_bare(ReadyMesh& ready) {
  if (ready.bare) return;
  const PolygonMesh& mesh = ready.mesh;
  ready.bare = std::make_shared<PolygonMesh>(PolygonMesh{.positions = mesh.positions,
                                                         .face_offsets = mesh.face_offsets,
                                                         .face_vertices = mesh.face_vertices,
                                                         .creases = mesh.creases,
                                                         .corners = mesh.corners,
                                                         .groups = mesh.groups,
                                                         .face_groups = mesh.face_groups,
                                                         .hole_faces = mesh.hole_faces});
}

bool pair_up(ReadyMesh& ready, std::optional<double> crease_degrees,
             std::span<const std::uint8_t> may_join) {
  PairedMesh paired =
      with_paired_triangles(ready.mesh, *ready.prepared, pair_options(crease_degrees, may_join));
  if (paired.pair_count == 0) return false;
  keep_bare(ready);
  ready.paired_count = paired.pair_count;
  take_faces(ready, std::move(paired.mesh), std::move(paired.source_faces), {});
  return true;
}

void make_fair(ReadyMesh& ready) {
  cut_concave_faces(ready);
  if (ready.prepared) ready.mesh = with_cusp_corners(ready.mesh);
}

PairOptions pair_options(std::optional<double> crease_degrees,
                         std::span<const std::uint8_t> may_join) {
  PairOptions options{.may_join = may_join};
  if (crease_degrees) options.largest_turn = std::min(options.largest_turn, *crease_degrees);
  return options;
}

ReadyMesh make_ready(PolygonMesh&& mesh, const Preparation& choice) {
  ReadyMesh ready;
  if (!choice.uses_tags) {
    mesh.creases.clear();
    mesh.corners.clear();
  }
  std::vector<std::int32_t> welded_sources;
  if (choice.weld)
    mesh = take_welded(weld_vertices(std::move(mesh), *choice.weld), welded_sources,
                       ready.welded_count);
  std::optional<Warning> shortened;
  if (choice.repairs && choice.stands_alone) {
    WeldedMesh welded = weld_short_edges(std::move(mesh));
    if (const std::int64_t count = welded.welded_count; count > 0) {
      const std::int32_t first = welded.first_welded;
      shortened = {
          "short-edges",
          formatted("vertices that coincide with a neighbour, made one with it: {}", count), count,
          welded_sources.empty() ? first : welded_sources[first]};
    }
    mesh = take_welded(std::move(welded), welded_sources, ready.welded_count);
  }
  ready.prepared = prepare_if_sound(mesh);
  if (ready.prepared || !choice.repairs) {
    ready.mesh = std::move(mesh);
  } else {
    static_cast<RepairedMesh&>(ready) = repair(mesh);
    ready.prepared = prepare_if_sound(ready.mesh);
  }
  name_sources(ready, std::move(welded_sources));
  // Ranks mend nothing, and what they make is what comes out without repair.
  if (choice.repairs && ready.prepared) cut_mirrored_charts(ready.mesh, ready.mesh.uvs);
  if (shortened) ready.changes.insert(ready.changes.begin(), *shortened);
  if (choice.repairs) take_out_flat_triangles(ready, choice.stands_alone);
  const bool searches = choice.found == nullptr && ready.prepared;
  if (choice.found != nullptr) {
    ready.found = *choice.found;
    add_tags(ready.mesh, ready.found);
  }
  if (choice.finds_features && searches)
    ready.found = add_features(ready.mesh, ready.prepared, {}, choice.features_done);
  if (choice.pairs_triangles && ready.prepared)
    pair_up(ready, choice.crease_degrees, choice.may_join);
  if (choice.repairs && choice.method == InterpolationMethod::Fair) make_fair(ready);
  // On the faces that the fair method has cut.
  if (choice.crease_degrees && searches)
    ready.found = add_features(ready.mesh, ready.prepared, {.every = choice.crease_degrees});
  return ready;
}

std::string creases_text(bool uses_tags, bool finds_features,
                         std::optional<double> crease_degrees) {
  if (finds_features) return "auto";
  if (crease_degrees) return "auto:" + shortest(*crease_degrees);
  return uses_tags ? "use" : "ignore";
}

void WarningList::add(const Warning& warning) const {
  const auto same = [&](const Warning& other) {
    return other.code == warning.code && other.message == warning.message;
  };
  if (std::ranges::any_of(list_, same)) return;
  list_.push_back(warning);
  caller_.warn(warning);
}

Preparation preparation_of(const MeshFitOptions& options, InterpolationMethod method,
                           std::span<const std::uint8_t> may_join) {
  return {.repairs = options.repairs,
          .uses_tags = options.fit.sharp.use_tags,
          .finds_features = options.finds_features,
          .crease_degrees = options.crease_degrees,
          .method = method,
          .weld = options.weld,
          .found = nullptr,
          .pairs_triangles = options.quads == QuadChoice::On,
          .may_join = may_join,
          .stands_alone = options.stands_alone};
}

void tell_changes(ReadyMesh& ready, std::string_view name, const WarningList& warnings) {
  for (Warning& change : std::exchange(ready.changes, {})) {
    change.message = std::string(name) + ": " + change.message;
    warnings.add(change);
  }
}

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

std::string MeshToFit::creases() const {
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
  MeshToFit& result = ready.input;
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
    static_cast<ReadyMesh&>(result) = make_ready(std::move(mesh), preparation);
    tell_changes(result, name, warnings);
  } catch (const Error& error) {
    if (error.code() == ErrorCode::UnusableMesh) require_usable(mesh, name);
    throw;
  }
  if (!result.prepared) require_usable(result.mesh, name);
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
    return static_cast<double>(2 * pairs) > kWorthPairing * ready.input.mesh.face_count();
  };
  if (given) {
    auto paired = std::make_shared<ReadyFit>(
        prepare_one(std::move(*given), ready.name, pairing, std::move(may_join)));
    return is_worth_it(paired->input.paired_count) ? std::move(paired) : nullptr;
  }
  MeshToFit joined = ready.input;
  if (!pair_up(joined, ready.options.crease_degrees, may_join) || !is_worth_it(joined.paired_count))
    return nullptr;
  joined.pairs_triangles = true;
  if (!joined.prepared) require_usable(joined.mesh, ready.name);
  auto paired = std::make_shared<ReadyFit>();
  paired->input = std::move(joined);
  paired->name = ready.name;
  paired->options = std::move(pairing);
  paired->chooses_method = ready.chooses_method;
  paired->may_join = std::move(may_join);
  return paired;
}

}  // namespace

void prepare_refined(ReadyFit& ready) {
  if (!may_refine(ready)) return;
  auto made = refine_mesh(ready.input.mesh, *ready.input.prepared);
  if (!made) return;
  ready.refined = std::make_shared<ReadyFit>();
  MeshToFit& refined = ready.refined->input;
  refined.prepared = prepare_mesh(made->mesh, ready.name);
  refined.mesh = std::move(made->mesh);
  refined.added_vertices = std::move(made->added);
  refined.density = ready.input.density;
  refined.density.is_refined = true;
}

ReadyFit cage_fit(const ReadyFit& ready) {
  ReadyFit cage;
  cage.name = ready.name;
  cage.options = ready.options;
  if (cage.options.refine == RefineChoice::Auto) cage.options.refine = RefineChoice::Off;
  cage.input = ready.input;
  if (!ready.chooses_method) return cage;
  cage.options.method = InterpolationMethod::Progressive;
  cage.input.options.method = InterpolationMethod::Progressive;
  cage.reason =
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
  // Which only one method has.
  if (!options.method && options.fit.scheme == Scheme::DooSabin && options.fit.sharp.use_tags &&
      options.fit.obeys_semi_sharp && has_semi_sharp(mesh)) {
    MeshFitOptions fair = options;
    fair.method = InterpolationMethod::Fair;
    ReadyFit ready = prepare_fit(std::move(mesh), name, fair);
    ready.reason = "fair: the mesh has semi-sharp edges, which the progressive method makes smooth";
    return ready;
  }
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
  const MeshDensity density = mesh_density(ready.input.mesh, *ready.input.prepared->topology);
  if (options.faces_are_given)
    if (const auto torn = torn_warning(ready.input, name))
      WarningList(ready.input.warnings, options.fit.callbacks).add(*torn);
  if (may_pair) {
    report(kOneReady);
    ready.looks =
        look_halved_by_parts(ready.input.mesh, *ready.input.prepared, options.crease_degrees);
    const auto are_all = [&](Halves look) {
      return std::ranges::all_of(ready.looks, [&](Halves one) { return one == look; });
    };
    std::vector<std::uint8_t> may_join;
    // What does not look like halves is worth a try where that costs little.
    const bool is_large = density.vertex_count >= kDenseVertices;
    if (is_large && !are_all(Halves::Maybe) && !are_all(Halves::Plain))
      for (const std::int32_t part : mesh_parts(ready.input.mesh).of_faces(ready.input.mesh))
        may_join.push_back(ready.looks[part] != Halves::No ? 1 : 0);
    if (!is_large || !are_all(Halves::No)) {
      report(kLookedHalved);
      ready.is_plainly_halved = are_all(Halves::Plain);
      ready.paired = prepare_paired(ready, std::move(given), std::move(may_join));
    }
  }
  for (ReadyFit* one : {&ready, ready.paired.get()}) {
    if (one == nullptr) continue;
    one->input.density = density;
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
  ready.options.fit.within = ready.input.options.within = 0.0;
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
  leaving.prepared = fitted.prepared;
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
      portable::hypot(centre.x, centre.y, centre.z) > kFarFromOrigin * placement.diagonal;
  return is_far ? centre : glm::dvec3(0.0);
}

SurfaceMesh tessellate(const PolygonMesh& mesh, const Fit& fit, AdaptiveOptions options,
                       const EvaluateOptions& evaluate) {
  const HostScope host(options.callbacks);
  const LimitSurface limit(fitted_surface(mesh, fit, evaluate));
  options.diagonal = fit.placement.diagonal;
  return tessellate(limit, options).mesh;
}

SurfaceMesh tessellate(const FittedMesh& fitted, const AdaptiveOptions& options) {
  if (fitted.options.scheme != Scheme::DooSabin) {
    throw Error(ErrorCode::InvalidArgument,
                "tessellate: only Doo-Sabin surfaces are tessellated by error and angle; fit with "
                "that scheme, or evaluate a level");
  }
  return tessellate(fitted.mesh, fitted.fit, options, fitted.evaluate_options());
}

}  // namespace planish
