#include "planish/pipeline/fit_mesh.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "planish/core/error.h"
#include "planish/core/version.h"
#include "planish/mesh/check.h"
#include "planish/pipeline/found_creases.h"
#include "planish/pipeline/make_ready.h"
#include "planish/pipeline/option_words.h"

namespace planish {
namespace {

Preparation preparation_of(const MeshFitOptions& options, InterpolationMethod method) {
  return {.repairs = options.repairs,
          .uses_tags = options.fit.sharp.use_tags,
          .crease_degrees = options.crease_degrees,
          .method = method,
          .weld = options.weld};
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
  result.changed_faces = std::move(ready.changed_faces);
  result.separated_edges = std::move(ready.separated_edges);
  result.source_vertices = std::move(ready.source_vertices);
  result.source_faces = std::move(ready.source_faces);
  result.options.prepared = std::move(ready.prepared);
}

void choose_method(FittedMesh& result, PolygonMesh&& given, std::string_view name, Backend& backend,
                   const MeshFitOptions& options, const WarningList& warnings) {
  ReadyMesh ready;
  const auto make_fair_mesh = [&] {
    ready = make_ready(std::move(given), preparation_of(options, InterpolationMethod::Fair));
    return FairMesh{std::move(ready.mesh), ready.prepared, std::move(ready.found)};
  };
  BestFit best = fit_best(result.mesh, backend, result.options, make_fair_mesh);
  result.reason = MethodReason{best.reason, best.progressive, best.fair};
  result.options.method = best.method;
  result.smoothed_vertices = std::move(best.smoothed_vertices);
  if (best.fair_mesh) {
    take(result, std::move(ready), name, warnings);
    result.mesh = std::move(*best.fair_mesh);
  }
  result.fit = std::move(best.fit);
}

}  // namespace

EvaluateOptions FittedMesh::evaluate_options(int level) const {
  return {
      .level = level, .scheme = options.scheme, .weights = options.weights, .sharp = options.sharp};
}

std::string FittedMesh::creases() const {
  return split_normals ? "normals" : creases_text(uses_tags, crease_degrees);
}

FittedMesh fit_mesh(PolygonMesh mesh, std::string_view name, Backend& backend,
                    const MeshFitOptions& options) {
  FittedMesh result;
  const WarningList warnings(result.warnings, options.fit.callbacks);
  result.options = options.fit;
  result.options.method = options.method.value_or(InterpolationMethod::Progressive);
  result.repairs = options.repairs;
  result.crease_degrees = options.crease_degrees;
  result.weld = options.weld;
  result.uses_tags = options.fit.sharp.use_tags;
  result.options.sharp.use_tags = true;  // what make_ready() left has none but those that count
  result.options.callbacks.warning = [&](const Warning& warning) { warnings.add(warning); };
  const bool chooses = !options.method && options.fit.scheme == Scheme::DooSabin;
  PolygonMesh given;
  std::optional<FoundCreases> found;
  if (chooses) given = mesh;
  try {
    ReadyMesh ready = make_ready(std::move(mesh), preparation_of(options, result.options.method));
    result.mesh = std::move(ready.mesh);
    found = std::move(ready.found);
    take(result, std::move(ready), name, warnings);
  } catch (const Error& error) {
    if (error.code() == ErrorCode::UnusableMesh) require_usable(mesh, name);
    throw;
  }
  if (!result.options.prepared) require_usable(result.mesh, name);
  try {
    if (chooses) {
      choose_method(result, std::move(given), name, backend, options, warnings);
    } else if (found) {
      CreasedFit creased = fit_with_found_creases(result.mesh, *found, backend, result.options);
      result.smoothed_vertices = std::move(creased.smoothed_vertices);
      result.fit = std::move(creased.fit);
    } else {
      result.fit = fit(result.mesh, backend, result.options);
    }
  } catch (const Error& error) {
    // fit() knows no name: say it again with the name.
    if (error.code() != ErrorCode::UnusableMesh) throw;
    throw Error(error.code(), std::string(name) + ": " + error.what(), error.element());
  }
  // The caller's callbacks end with the call.
  result.options.callbacks = {};
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
