#include <cmath>
#include <memory>
#include <string>

#include "planish/backend/cpu_backend.h"
#include "planish/c/call.h"
#include "planish/c/handles.h"
#include "planish/c/planish.h"
#include "planish/core/number_text.h"
#include "planish/mesh/weld_vertices.h"
#include "planish/pipeline/fit_file.h"
#include "planish/pipeline/verify_cage.h"

namespace planish::c {
namespace {

constexpr std::int32_t kMaxThreads = 4096;

void require_options(const planish_fit_options& options) {
  const auto out_of_range = [](const char* name, double value, const char* wanted) {
    refuse(std::string("options.") + name + " is " + shortest(value) + "; " + wanted);
  };
  if (options.method < PLANISH_METHOD_AUTO || options.method > PLANISH_METHOD_FAIR)
    out_of_range("method", options.method, "a planish_method is wanted");
  if (options.scheme < PLANISH_SCHEME_DOO_SABIN || options.scheme > PLANISH_SCHEME_LOOP)
    out_of_range("scheme", options.scheme, "a planish_scheme is wanted");
  if (!(options.tolerance > 0 && options.tolerance <= 1))
    out_of_range("tolerance", options.tolerance, "a fraction above 0 and up to 1 is wanted");
  if (options.max_iterations < 0 || options.max_iterations > 1'000'000)
    out_of_range("max_iterations", options.max_iterations, "0 to 1000000 is wanted");
  if (!(options.crease_degrees >= 0 && options.crease_degrees <= 180))
    out_of_range("crease_degrees", options.crease_degrees, "0 to 180 is wanted");
  if (!can_weld_within(options.weld))
    out_of_range("weld", options.weld, "0, or 1e-12 to less than 0.1 is wanted");
  if (options.thread_count < 0 || options.thread_count > kMaxThreads)
    out_of_range("thread_count", options.thread_count, "0 to 4096 is wanted");
}

// progress() is asked whether to go on, and its answer kept for the places that look at it.
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

std::unique_ptr<Backend> backend_of(const FitOptions& options, int thread_count) {
  return make_cpu_backend(
      {.solve_precision = precision_for(options.tolerance), .thread_count = thread_count});
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
  return info;
}

planish_status convergence_status(const FittedMesh& fitted) {
  const Interpolation& found = fitted.fit.interpolation;
  if (found.converged) return PLANISH_OK;
  const std::string message = "not converged: the largest error is " + shortest(found.error.max) +
                              " of the diagonal after iteration " +
                              std::to_string(found.iterations) + ", and options.tolerance " +
                              shortest(fitted.options.tolerance) +
                              "; allow more of either, or take PLANISH_METHOD_FAIR";
  note(message.c_str(), -1);
  return PLANISH_NOT_CONVERGED;
}

}  // namespace

MeshFitOptions mesh_options(const planish_fit_options& options) {
  require_options(options);
  MeshFitOptions how;
  if (options.method == PLANISH_METHOD_PROGRESSIVE) how.method = InterpolationMethod::Progressive;
  if (options.method == PLANISH_METHOD_FAIR) how.method = InterpolationMethod::Fair;
  if (options.scheme == PLANISH_SCHEME_CATMULL_CLARK) how.fit.scheme = Scheme::CatmullClark;
  if (options.scheme == PLANISH_SCHEME_LOOP) how.fit.scheme = Scheme::Loop;
  how.repairs = options.repairs != 0;
  if (options.crease_degrees > 0) how.crease_degrees = options.crease_degrees;
  if (options.weld > 0) how.weld = options.weld;
  how.fit.tolerance = options.tolerance;
  how.fit.max_iterations = options.max_iterations;
  how.fit.sharp.use_tags = options.uses_creases != 0;
  how.fit.callbacks = callbacks_of(options);
  return how;
}

}  // namespace planish::c

using namespace planish::c;

void planish_fit_options_init(planish_fit_options* options, size_t struct_size) {
  planish_fit_options defaults{};
  defaults.tolerance = 1e-6;
  defaults.max_iterations = 200;
  defaults.repairs = 1;
  defaults.uses_creases = 1;
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
    const planish::MeshFitOptions how = mesh_options(own);
    auto made = std::make_unique<planish_fit>();
    made->thread_count = own.thread_count;
    const auto backend = backend_of(how.fit, own.thread_count);
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

planish_status planish_fit_cage(const planish_fit* fit, planish_mesh** cage) {
  return call([&] {
    require(fit, "fit");
    require(cage, "cage");
    const planish::FittedMesh& fitted = fit->fitted;
    *cage = new_mesh(planish::control_cage(fitted.mesh, fitted.fit, fitted.options.sharp));
    return PLANISH_OK;
  });
}

planish_status planish_fit_write(const planish_fit* fit, int32_t level, const char* path) {
  return call([&] {
    require(fit, "fit");
    require(path, "path");
    const auto backend = backend_of(fit->fitted.options, fit->thread_count);
    planish::write_fitted_surface(path, fit->fitted, "surface", *backend, {.level = level});
    return convergence_status(fit->fitted);
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
    how.mesh = mesh_options(own);
    how.level = level;
    const auto backend = backend_of(how.mesh.fit, own.thread_count);
    how.backend = backend.get();
    const planish::FileFit done = planish::fit_file(input, output, how);
    if (info != nullptr) give(info_of(done.fitted), info, "info");
    return convergence_status(done.fitted);
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
    const planish::MeshFitOptions how =
        mesh_options(taken(options, planish_fit_options_init, "options"));
    planish::VerifyOptions verify;
    verify.method = how.method.value_or(planish::InterpolationMethod::Progressive);
    verify.scheme = how.fit.scheme;
    verify.sharp = how.fit.sharp;
    verify.repairs = how.repairs;
    verify.crease_degrees = how.crease_degrees;
    verify.weld = how.weld;
    verify.tolerance = how.fit.tolerance;
    const planish::Verification found = planish::verify_cage(cage->mesh, given->mesh, verify);
    planish_verification own;
    planish_verification_init(&own, sizeof own);
    own.confirmed = found.confirmed ? 1 : 0;
    own.max_error = found.error.max;
    own.rms_error = found.error.rms;
    own.worst_vertex = found.worst_vertex;
    own.vertex_count = found.vertex_count;
    give(own, verification, "verification");
    return PLANISH_OK;
  });
}
