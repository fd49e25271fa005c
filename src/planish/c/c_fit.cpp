#include <cmath>
#include <memory>
#include <string>

#include "planish/backend/cpu_backend.h"
#include "planish/c/call.h"
#include "planish/c/handles.h"
#include "planish/c/planish.h"
#include "planish/core/formatted.h"
#include "planish/core/number_text.h"
#include "planish/pipeline/fit_file.h"
#include "planish/pipeline/option_table.h"
#include "planish/pipeline/verify_cage.h"

namespace planish::c {
namespace {

constexpr std::int32_t kMaxThreads = 4096;
constexpr double kNoWeld = -1, kMeasured = -1;

[[noreturn]] void out_of_range(std::string_view name, double value, const char* wanted) {
  refuse(formatted("options.{} is {}; {}", name, shortest(value), wanted));
}

std::string spelled(std::string_view name) {
  return "options." + std::string(name == "interpolation" ? "method" : name);
}

void set_number(FitSettings& settings, std::string_view name, double value) {
  set_option(fit_option(name), settings, {.number = value}, spelled(name));
}

void set_whole(FitSettings& settings, std::string_view name, std::int32_t value) {
  set_option(fit_option(name), settings, {.whole = value}, spelled(name));
}

// The enums of planish.h have the words of the options in their order.
void set_choice(FitSettings& settings, std::string_view name, std::int32_t value,
                const char* wanted) {
  const FitOption& option = fit_option(name);
  if (value < 0 || static_cast<std::size_t>(value) >= option.words.size())
    refuse(formatted("{} is {}; {}", spelled(name), value, wanted));
  set_option(option, settings, {.text = option.words[static_cast<std::size_t>(value)]},
             spelled(name));
}

void set_creases(FitSettings& settings, const planish_fit_options& options) {
  if (options.creases != nullptr) {
    read_option(fit_option("creases"), settings, options.creases, spelled("creases"));
    return;
  }
  if (!(options.crease_degrees >= 0 && options.crease_degrees <= 180))
    out_of_range("crease_degrees", options.crease_degrees, "0 to 180 is wanted");
  settings.creases.use_tags = options.uses_creases != 0;
  if (options.crease_degrees > 0) settings.creases.dihedral_degrees = options.crease_degrees;
}

// An exception out of progress() ends the work, as whatever a callback throws.
Callbacks callbacks_of(const planish_fit_options& options) {
  Callbacks callbacks;
  if (options.progress != nullptr) {
    callbacks.progress = [options](std::string_view step, double fraction) {
      if (options.progress(options.user, std::string(step).c_str(), fraction) != 0)
        throw Error(ErrorCode::Cancelled, "cancelled");
    };
  }
  if (options.warning != nullptr) {
    callbacks.warning = [options](const Warning& warning) {
      options.warning(options.user, warning.code.c_str(), warning.message.c_str());
    };
  }
  return callbacks;
}

std::unique_ptr<Backend> backend_of(Precision precision, int thread_count) {
  return make_cpu_backend({.solve_precision = precision, .thread_count = thread_count});
}

planish_fit_info info_of(const FittedMesh& fitted) {
  planish_fit_info info;
  planish_fit_info_init(&info, sizeof info);
  const Interpolation& result = fitted.fit.interpolation;
  info.converged = result.converged ? 1 : 0;
  info.iterations = result.iterations;
  info.method = fitted.options.method == InterpolationMethod::Fair ? PLANISH_METHOD_FAIR
                                                                   : PLANISH_METHOD_PROGRESSIVE;
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
            "options.tolerance {}; allow more of either, or take PLANISH_METHOD_FAIR",
            shortest(found.error.max), found.iterations, shortest(fitted.options.tolerance));
      },
      "not converged");
  return PLANISH_NOT_CONVERGED;
}

// Of a surface that was written, as STEP where there are figures of that.
planish_status written_status(const FittedMesh& fitted, const StepFigures* step) {
  const planish_status status = convergence_status(fitted);
  if (status != PLANISH_OK || step == nullptr || step->is_as_asked()) return status;
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

FitSettings settings_of(const planish_fit_options& options) {
  FitSettings settings;
  set_choice(settings, "interpolation", options.method, "a planish_method is wanted");
  set_choice(settings, "scheme", options.scheme, "a planish_scheme is wanted");
  set_choice(settings, "weights", options.weights, "a planish_weights is wanted");
  set_choice(settings, "solver", options.solver, "a planish_solver is wanted");
  set_choice(settings, "boundary", options.boundary, "a planish_boundary is wanted");
  set_choice(settings, "precision", options.precision, "a planish_precision is wanted");
  set_choice(settings, "quads", options.quads, "a planish_quads is wanted");
  set_choice(settings, "textures", options.textures, "a planish_textures is wanted");
  set_choice(settings, "refine", options.refine, "a planish_refine is wanted");
  set_choice(settings, "step_unit", options.step_unit, "a planish_step_unit is wanted");
  set_number(settings, "step_angle", options.step_angle);
  set_number(settings, "step_tolerance", options.step_tolerance);
  set_whole(settings, "step_face_size", options.step_face_size);
  set_number(settings, "tolerance", options.tolerance);
  if (options.weld != kNoWeld) set_number(settings, "weld", options.weld);
  set_whole(settings, "max_iterations", options.max_iterations);
  set_whole(settings, "polish", options.polish);
  set_creases(settings, options);
  if (options.within != 0)
    read_option(fit_option("within"), settings,
                options.within == kMeasured ? "auto" : shortest(options.within), spelled("within"));
  settings.repair = options.repairs != 0 ? RepairChoice::Safe : RepairChoice::None;
  if (options.thread_count < 0 || options.thread_count > kMaxThreads)
    out_of_range("thread_count", options.thread_count, "0 to 4096 is wanted");
  check_consistent(settings, spelled);
  return settings;
}

// Of a mesh that is no file.
FitSettings mesh_settings_of(const planish_fit_options& options) {
  FitSettings settings = settings_of(options);
  if (settings.creases.split_normals)
    refuse("options.creases: normals are a file's; take planish_fit_file()");
  return settings;
}

MeshFitOptions mesh_options(const FitSettings& settings, const planish_fit_options& options) {
  MeshFitOptions how = mesh_fit_options(settings);
  how.fit.callbacks = callbacks_of(options);
  return how;
}

}  // namespace
}  // namespace planish::c

using namespace planish::c;

void planish_fit_options_init(planish_fit_options* options, size_t struct_size) {
  const planish::FitSettings own;
  planish_fit_options defaults{};
  defaults.tolerance = own.tolerance;
  defaults.max_iterations = own.max_iterations;
  defaults.repairs = 1;
  defaults.uses_creases = 1;
  defaults.weld = kNoWeld;
  defaults.polish = own.polish_steps;
  defaults.step_angle = own.step.faces.angle;
  defaults.step_tolerance = own.step.faces.deviation;
  defaults.step_unit = PLANISH_STEP_AUTO;
  defaults.step_face_size = own.step.faces.face_size;
  start(defaults, options, struct_size);
}

void planish_fit_info_init(planish_fit_info* info, size_t struct_size) {
  start({}, info, struct_size);
}

planish_status planish_fit_create(const planish_mesh* mesh, const planish_fit_options* options,
                                  planish_fit** fit) {
  return call([&] {
    require(mesh, "mesh");
    require(fit, "fit");
    const planish_fit_options own = taken(options, planish_fit_options_init, "options");
    const planish::FitSettings settings = mesh_settings_of(own);
    const planish::MeshFitOptions how = mesh_options(settings, own);
    auto made = std::make_unique<planish_fit>();
    made->thread_count = own.thread_count;
    made->precision = solve_precision(settings);
    made->step = settings.step;
    made->inputs = mesh->inputs;
    const auto backend = backend_of(made->precision, own.thread_count);
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
    run_on(fit->thread_count, [&] {
      auto made = new_mesh(planish::control_cage(fitted.mesh, fitted.fit, fitted.options.sharp));
      made->inputs = fit->inputs;
      *cage = made.release();
    });
    return PLANISH_OK;
  });
}

planish_status planish_fit_write(const planish_fit* fit, int32_t level, const char* path) {
  return call([&] {
    require(fit, "fit");
    require(path, "path");
    const auto backend = backend_of(fit->precision, fit->thread_count);
    planish::StepFigures figures;
    const planish::InputFiles inputs = fit->inputs;  // other threads may write the fit, too
    planish::write_fitted_surface(path, fit->fitted, "surface", *backend,
                                  {.level = fit->settled(level),
                                   .step = fit->step,
                                   .step_figures = &figures,
                                   .inputs = &inputs});
    return written_status(fit->fitted, &figures);
  });
}

void planish_fit_free(planish_fit* fit) { delete fit; }

planish_status planish_fit_file(const char* input, const char* output, int32_t level,
                                const planish_fit_options* options, planish_fit_info* info) {
  return call([&] {
    require(input, "input");
    require(output, "output");
    const planish_fit_options own = taken(options, planish_fit_options_init, "options");
    planish::FitFileOptions how;
    const planish::FitSettings settings = settings_of(own);
    how.mesh = mesh_options(settings, own);
    how.split_normals = settings.creases.split_normals;
    if (level != PLANISH_LEVEL_AUTO) how.level = level;
    if (own.coarser_level_count > 0) {
      require(own.coarser_levels, "options.coarser_levels");
      how.coarser_levels.assign(own.coarser_levels, own.coarser_levels + own.coarser_level_count);
    }
    how.textures = settings.textures;
    how.step = settings.step;
    const auto backend = backend_of(solve_precision(settings), own.thread_count);
    how.backend = backend.get();
    const planish::FileFit done = planish::fit_file(input, output, how);
    if (info != nullptr) give(info_of(done.fitted), info, "info");
    return written_status(done.fitted, done.step ? &*done.step : nullptr);
  });
}

void planish_verification_init(planish_verification* verification, size_t struct_size) {
  start({}, verification, struct_size);
}

planish_status planish_verify(const planish_mesh* cage, const planish_mesh* given,
                              const planish_fit_options* options,
                              planish_verification* verification) {
  return call([&] {
    require(cage, "cage");
    require(given, "given");
    const planish_fit_options how = taken(options, planish_fit_options_init, "options");
    planish::VerifyOptions verify = verify_options(mesh_settings_of(how));
    if (how.sharp_edge_count > 0) require(how.sharp_edges, "options.sharp_edges");
    if (how.sharp_corner_count > 0) require(how.sharp_corners, "options.sharp_corners");
    planish::FoundCreases sharp;
    for (size_t i = 0; i < how.sharp_edge_count; ++i)
      sharp.edges.push_back({how.sharp_edges[2 * i], how.sharp_edges[2 * i + 1]});
    sharp.corners.assign(how.sharp_corners, how.sharp_corners + how.sharp_corner_count);
    if (how.sharp_edges != nullptr || how.sharp_corners != nullptr) verify.found = &sharp;
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
