#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "planish/c/call.h"
#include "planish/c/handles.h"
#include "planish/c/options.h"
#include "planish/c/planish.h"
#include "planish/core/formatted.h"
#include "planish/core/number_text.h"
#include "planish/core/refuse.h"
#include "planish/job/fit_file.h"
#include "planish/pipeline/verify_cage.h"

namespace planish::c {
namespace {

planish_fit_info info_of(const FittedMesh& fitted) {
  planish_fit_info info;
  planish_fit_info_init(&info, sizeof info);
  const Interpolation& result = fitted.fit.interpolation;
  info.converged = result.converged ? 1 : 0;
  info.iterations = result.iterations;
  info.interpolation = fitted.options.method == InterpolationMethod::Fair ? "fair" : "progressive";
  info.max_error = result.error.max;
  info.rms_error = result.error.rms;
  info.diagonal = fitted.fit.placement.diagonal;
  info.vertex_count = fitted.mesh.positions.size();
  info.face_count = static_cast<std::size_t>(fitted.mesh.face_count());
  info.warning_count = fitted.warnings.size();
  info.finds_features = fitted.finds_features ? 1 : 0;
  info.crease_degrees = fitted.crease_degrees.value_or(0);
  if (fitted.fit.within) info.within = fitted.fit.within->within;
  return info;
}

planish_status convergence_status(const FittedMesh& fitted) {
  const Interpolation& found = fitted.fit.interpolation;
  if (found.converged) return PLANISH_OK;
  note_of_results(
      [&] {
        return formatted(
            "not converged: the largest error is {} of the diagonal after iteration {}, and "
            "options.tolerance {}; allow more of either, or take options.interpolation fair",
            shortest(found.error.max), found.iterations, shortest(fitted.options.tolerance));
      },
      "not converged");
  return PLANISH_NOT_CONVERGED;
}

// Of a surface that was written, as STEP where there are figures of that.
planish_status written_status(const FittedMesh& fitted, const std::optional<StepFigures>& step) {
  const planish_status status = convergence_status(fitted);
  if (status != PLANISH_OK || !step || step->is_as_asked()) return status;
  if (!step->check.is_valid()) {
    note_of_results(
        [&] {
          return formatted(
              "the shell is not valid: {} loops are not closed, {} edges not shared as they must "
              "be, edges off their faces by up to {} of the diagonal; mend the mesh there",
              step->check.broken_loops, step->check.unmatched_edges,
              shortest(step->check.largest_gap));
        },
        "the file's shell is not valid");
    return PLANISH_NOT_CONVERGED;
  }
  note_of_results(
      [&] {
        return formatted(
            "normals jump by up to {} degrees where faces meet, {}, and faces leave the surface by "
            "up to {} of the diagonal, {}; allow more by options.step_angle and "
            "options.step_tolerance, or mend the mesh there",
            shortest(step->max_angle), words_of(step->max_angle_at), shortest(step->max_deviation),
            words_of(step->max_deviation_at));
      },
      "the file does not keep options.step_angle and options.step_tolerance");
  return PLANISH_NOT_CONVERGED;
}

// Here one file is written.
void require_one_file(const Settings& settings) {
  if (settings.lods == LodChoice::Msft) return;
  const bool is_adaptive = settings.adaptive.any();
  if (std::max(is_adaptive ? 0 : settings.levels.size(), settings.adaptive.chord_errors.size()) > 1)
    planish::refuse(spelled(is_adaptive ? "chord_errors" : "levels"),
                    "several are a file each; take one, or {} msft for levels of detail of a glTF",
                    spelled("lods"));
}

// With the caller's functions.
MeshFitOptions mesh_options(const FitSettings& settings, const planish_options& options) {
  MeshFitOptions how = mesh_fit_options(settings);
  how.fit.callbacks = callbacks_of(options);
  return how;
}

}  // namespace
}  // namespace planish::c

using namespace planish::c;

void planish_fit_info_init(planish_fit_info* info, size_t struct_size) {
  start({}, info, struct_size);
}

planish_status planish_fit_create(const planish_mesh* mesh, const planish_options* options,
                                  planish_fit** fit) {
  return call([&] {
    require(mesh, "mesh");
    require(fit, "fit");
    const planish_options& own = options_of(options);
    const planish::Settings& settings = mesh_settings(own);
    const planish::MeshFitOptions how = mesh_options(settings, own);
    auto made = std::make_unique<planish_fit>();
    made->kept = {own.thread_count, settings, mesh->inputs};
    const auto backend = made->kept.make_backend();
    made->fitted = planish::fit_mesh(mesh->mesh, "mesh", *backend, how);
    *fit = made.release();
    return convergence_status((*fit)->fitted);
  });
}

planish_status planish_fit_get_info(const planish_fit* fit, planish_fit_info* info) {
  return call([&] {
    require(fit, "fit");
    give(info_of(fit->fitted), info, "info");
    return PLANISH_OK;
  });
}

planish_status planish_fit_sharp(const planish_fit* fit, const int32_t** edges, size_t* edge_count,
                                 const int32_t** corners, size_t* corner_count) {
  return call([&] {
    require(fit, "fit");
    require(edges, "edges");
    require(edge_count, "edge_count");
    require(corners, "corners");
    require(corner_count, "corner_count");
    const planish::FoundCreases& found = fit->fitted.found;
    static constexpr int32_t kNone = 0;  // no array of none is NULL: it would be looked for
    *edges = found.edges.empty() ? &kNone : found.edges.front().data();
    *edge_count = found.edges.size();
    *corners = found.corners.empty() ? &kNone : found.corners.data();
    *corner_count = found.corners.size();
    return PLANISH_OK;
  });
}

planish_status planish_fit_cage(const planish_fit* fit, planish_mesh** cage) {
  return call([&] {
    require(fit, "fit");
    require(cage, "cage");
    const planish::FittedMesh& fitted = fit->fitted;
    run_on(fit->kept.thread_count, [&] {
      auto made = new_mesh(planish::control_cage(fitted.mesh, fitted.fit, fitted.options.sharp));
      made->inputs = fit->kept.inputs;
      *cage = made.release();
    });
    return PLANISH_OK;
  });
}

planish_status planish_fit_write(const planish_fit* fit, int32_t level, const char* path) {
  return call([&] {
    require(fit, "fit");
    require(path, "path");
    const auto backend = fit->kept.make_backend();
    // Other threads may write the fit, too.
    const planish::InputFiles inputs = fit->kept.inputs;
    planish::SurfaceFileOptions how{.settings = fit->kept.settings, .inputs = &inputs};
    if (level != PLANISH_LEVEL_AUTO) how.settings.adaptive = {};
    if (!how.settings.levels_by_density || level != PLANISH_LEVEL_AUTO)
      how.settings.set_levels({fit->settled(level)});
    require_one_file(how.settings);
    const planish::WrittenOutput written =
        planish::write_fitted_surface(path, fit->fitted, *backend, how);
    return written_status(fit->fitted, written.step);
  });
}

void planish_fit_free(planish_fit* fit) { delete fit; }

planish_status planish_fit_file(const char* input, const char* output,
                                const planish_options* options, planish_fit_info* info) {
  return call([&] {
    require(input, "input");
    require(output, "output");
    const planish_options& own = options_of(options);
    const planish::Settings& settings = consistent_settings(own);
    require_one_file(settings);
    const auto backend = Kept{own.thread_count, settings, {}}.make_backend();
    const planish::FitFileOptions how{.settings = settings,
                                      .cage = own.file("cage"),
                                      .report = own.file("report"),
                                      .page = own.file("page"),
                                      .source = own.file("source"),
                                      .limits = own.limits,
                                      .callbacks = callbacks_of(own),
                                      .backend = backend.get()};
    const planish::FileFit done = planish::fit_file(input, output, how);
    if (info != nullptr) give(info_of(done.fitted), info, "info");
    return written_status(done.fitted, done.step);
  });
}

void planish_verification_init(planish_verification* verification, size_t struct_size) {
  start({}, verification, struct_size);
}

planish_status planish_verify(const planish_mesh* cage, const planish_mesh* given,
                              const planish_options* options, planish_verification* verification) {
  return call([&] {
    require(cage, "cage");
    require(given, "given");
    const planish_options& how = options_of(options);
    planish::VerifyOptions verify = verify_options(mesh_settings(how));
    if (how.sharp) verify.found = &*how.sharp;
    planish::Verification result;
    run_on(how.thread_count,
           [&] { result = planish::verify_cage(cage->mesh, given->mesh, verify); });
    planish_verification own;
    planish_verification_init(&own, sizeof own);
    own.confirmed = result.confirmed ? 1 : 0;
    own.max_error = result.error.max;
    own.rms_error = result.error.rms;
    own.worst_vertex = result.worst_vertex;
    own.vertex_count = result.vertex_count;
    give(own, verification, "verification");
    return PLANISH_OK;
  });
}
