#include <cmath>
#include <cstddef>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "planish/c/handles.h"
#include "planish/c/planish.h"
#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/parallel.h"
#include "planish/core/words.h"
#include "planish/job/fit_file.h"
#include "planish/pipeline/fit.h"
#include "planish/pipeline/fit_mesh.h"
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
  const std::vector<std::string_view> kinds = settings.adaptive.kinds();
  if ((kinds.empty() ? settings.levels.size() : settings.adaptive.count()) > 1)
    planish::refuse(spelled(kinds.empty() ? "levels" : kinds[0]),
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
        planish::write_fitted_surface(planish::path_of(path), fit->fitted, *backend, how);
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
                                      .cage = planish::path_of(own.file("cage")),
                                      .report = planish::path_of(own.file("report")),
                                      .page = planish::path_of(own.file("page")),
                                      .source = planish::path_of(own.file("source")),
                                      .limits = own.limits,
                                      .callbacks = callbacks_of(own),
                                      .backend = backend.get()};
    const planish::FileFit done =
        planish::fit_file(planish::path_of(input), planish::path_of(output), how);
    if (info != nullptr) give(info_of(done.fitted), info, "info");
    return written_status(done.fitted, done.step);
  });
}

planish_status planish_fit_files(const char* const* inputs, size_t input_count, const char* folder,
                                 const char* extension, const planish_options* options,
                                 void (*failed)(void* user, size_t input, const char* message),
                                 void* user) {
  return call([&] {
    require(folder, "folder");
    if (input_count > 0) require(inputs, "inputs");
    const planish_options& own = options_of(options);
    const planish::Settings& settings = consistent_settings(own);
    for (const char* const file : {"report", "cage", "source"})
      if (!own.file(file).empty())
        planish::refuse(spelled(file), "is of one file; planish_fit_file() has it");
    std::vector<std::filesystem::path> from;
    for (std::size_t i = 0; i < input_count; ++i) {
      require(inputs[i], "inputs");
      from.push_back(planish::path_of(inputs[i]));
    }
    const auto backend = Kept{own.thread_count, settings, {}}.make_backend();
    const std::vector<std::string> messages =
        planish::fit_files(from, planish::path_of(folder),
                           {.settings = settings,
                            .extension = extension == nullptr ? "glb" : extension,
                            .pages = planish::path_of(own.file("page")),
                            .limits = own.limits,
                            .callbacks = callbacks_of(own),
                            .backend = backend.get()});
    for (std::size_t i = 0; failed != nullptr && i < messages.size(); ++i)
      if (!messages[i].empty()) failed(user, i, planish::visible(messages[i]).c_str());
    return PLANISH_OK;
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

void planish_surface_arrays_init(planish_surface_arrays* arrays, size_t struct_size) {
  start({}, arrays, struct_size);
}

planish_status planish_fit_evaluate(const planish_fit* fit, int32_t level,
                                    planish_surface** surface) {
  return call([&] {
    require(fit, "fit");
    require(surface, "surface");
    const int splits = fit->settled(level);
    planish::require_level(splits);
    const planish::FittedMesh& fitted = fit->fitted;
    const auto backend = fit->kept.make_backend();
    auto made = std::make_unique<planish_surface>();
    planish::EvaluateOptions options = fitted.evaluate_options(splits);
    options.callbacks = made->callbacks();
    made->surface = planish::evaluate(fitted.mesh, fitted.fit, *backend, options);
    made->riders.take(made->surface);
    *surface = made.release();
    return PLANISH_OK;
  });
}

planish_status planish_fit_tessellate(const planish_fit* fit, double chord_error, double angle,
                                      planish_surface** surface) {
  return call([&] {
    require(fit, "fit");
    require(surface, "surface");
    auto made = std::make_unique<planish_surface>();
    run_on(fit->kept.thread_count, [&] {
      made->surface = planish::tessellate(
          fit->fitted,
          {.chord_error = chord_error, .angle = angle, .callbacks = made->callbacks()});
    });
    made->riders.take(made->surface);
    *surface = made.release();
    return PLANISH_OK;
  });
}

size_t planish_surface_warning_count(const planish_surface* surface) {
  return surface == nullptr ? 0 : surface->warnings.size();
}

planish_status planish_surface_warning(const planish_surface* surface, size_t index,
                                       const char** code, const char** message) {
  return call([&] {
    require(surface, "surface");
    give_warning(surface->warnings, "surface", index, code, message);
    return PLANISH_OK;
  });
}

planish_status planish_surface_view(const planish_surface* surface,
                                    planish_surface_arrays* arrays) {
  return call([&] {
    require(surface, "surface");
    const planish::SurfaceMesh& from = surface->surface;
    planish_surface_arrays own;
    planish_surface_arrays_init(&own, sizeof own);
    own.vertex_count = from.positions.size();
    if (own.vertex_count > 0) {
      own.positions = &from.positions[0].x;
      own.normals = &from.normals[0].x;
    }
    own.face_vertices = from.face_vertices.data();
    own.corner_count = from.face_vertices.size();
    if (!from.face_offsets.empty()) own.face_offsets = from.face_offsets.data();
    own.face_count = static_cast<std::size_t>(from.face_count());
    own.base_vertices = from.base_vertices.data();
    own.base_count = from.base_vertices.size();
    surface->riders.give(from, own);
    give(own, arrays, "arrays");
    return PLANISH_OK;
  });
}

void planish_surface_free(planish_surface* surface) { delete surface; }

namespace planish::c {
namespace {

constexpr std::size_t kQueryGrain = 64;

// The mesh is left where it is by a fit that is freed.
LimitSurface limit_of(const planish_fit& fit) {
  if (fit.fitted.options.scheme != Scheme::DooSabin)
    refuse("only Doo-Sabin surfaces answer; take options.scheme doo-sabin");
  return LimitSurface(
      fitted_surface(fit.fitted.mesh, fit.fitted.fit, fit.fitted.evaluate_options()));
}

// The parts of every question, before memory is taken for so many.
void require_question(const planish_queries* queries, std::size_t count, const void* answers) {
  require(queries, "queries");
  require(answers, "answers");
  constexpr std::size_t kMost = std::numeric_limits<std::int32_t>::max();
  if (count > kMost) refuse(formatted("count is {}, more than 2^31 - 1; ask in parts", count));
}

glm::dvec3 vector_at(const double* values, std::size_t i) {
  return {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
}

void put(double* values, std::size_t i, const glm::dvec3& vector) {
  if (values == nullptr) return;
  for (int d = 0; d < 3; ++d) values[3 * i + static_cast<std::size_t>(d)] = vector[d];
}

template <class Value>
void put(Value* values, std::size_t i, Value value) {
  if (values != nullptr) values[i] = value;
}

planish_place place_of(const SurfaceParameter& at) { return {at.face, at.u, at.v}; }

void answer(const planish_place_answers& to, std::size_t i, const SurfacePoint& point) {
  put(to.positions, i, point.position);
  put(to.normals, i, point.normal);
  put(to.du, i, point.du);
  put(to.dv, i, point.dv);
  put(to.duu, i, point.duu);
  put(to.duv, i, point.duv);
  put(to.dvv, i, point.dvv);
  put(to.has_second, i, std::int32_t{point.has_second});
  if (to.mean == nullptr && to.gaussian == nullptr && to.largest == nullptr &&
      to.smallest == nullptr && to.largest_directions == nullptr &&
      to.smallest_directions == nullptr)
    return;
  const PointCurvature curvature = point.curvature();
  put(to.mean, i, curvature.mean);
  put(to.gaussian, i, curvature.gaussian);
  put(to.largest, i, curvature.largest);
  put(to.smallest, i, curvature.smallest);
  put(to.largest_directions, i, curvature.largest_direction);
  put(to.smallest_directions, i, curvature.smallest_direction);
}

void answer(const planish_ray_answers& to, std::size_t i, const std::optional<SurfaceHit>& hit) {
  const SurfaceHit found = hit.value_or(SurfaceHit{});
  put(to.places, i, hit ? place_of(found.at) : planish_place{-1, 0, 0});
  put(to.positions, i, found.position);
  put(to.normals, i, found.normal);
  put(to.t, i, found.t);
  put(to.is_tangent, i, std::int32_t{found.is_tangent});
}

}  // namespace
}  // namespace planish::c

void planish_place_answers_init(planish_place_answers* answers, size_t struct_size) {
  start({}, answers, struct_size);
}

void planish_closest_answers_init(planish_closest_answers* answers, size_t struct_size) {
  start({}, answers, struct_size);
}

void planish_ray_answers_init(planish_ray_answers* answers, size_t struct_size) {
  start({}, answers, struct_size);
}

planish_status planish_queries_create(const planish_fit* fit, planish_queries** queries) {
  return call([&] {
    require(fit, "fit");
    require(queries, "queries");
    auto made = std::make_unique<planish_queries>();
    made->source = fit->whole;
    made->thread_count = fit->kept.thread_count;
    run_on(fit->kept.thread_count, [&] {
      made->own_limit = std::make_unique<const planish::LimitSurface>(limit_of(*fit));
      made->own = std::make_unique<const planish::SurfaceQueries>(*made->own_limit);
    });
    made->queries = made->own.get();
    *queries = made.release();
    return PLANISH_OK;
  });
}

void planish_queries_free(planish_queries* queries) { delete queries; }

planish_status planish_queries_evaluate(const planish_queries* queries, const planish_place* places,
                                        size_t count, const planish_place_answers* answers) {
  return call([&] {
    require_question(queries, count, answers);
    if (count > 0) require(places, "places");
    const planish_place_answers to = taken(answers, planish_place_answers_init, "answers");
    std::vector<planish::SurfaceParameter> at(count);
    for (std::size_t i = 0; i < count; ++i) at[i] = {places[i].face, places[i].u, places[i].v};
    std::vector<planish::SurfacePoint> points(count);
    run_on(queries->thread_count, [&] {
      queries->queries->surface().evaluate(at, points);
      planish::parallel_each(count, kQueryGrain, [&](std::size_t i) { answer(to, i, points[i]); });
    });
    return PLANISH_OK;
  });
}

planish_status planish_queries_closest(const planish_queries* queries, const double* points,
                                       size_t count, const planish_closest_answers* answers) {
  return call([&] {
    require_question(queries, count, answers);
    if (count > 0) require(points, "points");
    const planish_closest_answers to = taken(answers, planish_closest_answers_init, "answers");
    std::vector<glm::dvec3> from(count);
    for (std::size_t i = 0; i < count; ++i) from[i] = vector_at(points, i);
    std::vector<planish::ClosestPoint> found(count);
    run_on(queries->thread_count, [&] { queries->queries->closest(from, found); });
    for (std::size_t i = 0; i < count; ++i) {
      put(to.places, i, place_of(found[i].at));
      put(to.positions, i, found[i].position);
      put(to.normals, i, found[i].normal);
      put(to.distances, i, found[i].distance);
    }
    return PLANISH_OK;
  });
}

planish_status planish_queries_first_hit(const planish_queries* queries, const double* origins,
                                         const double* directions, size_t count, double t_min,
                                         double t_max, const planish_ray_answers* answers) {
  return call([&] {
    require_question(queries, count, answers);
    if (count > 0) require(origins, "origins");
    if (count > 0) require(directions, "directions");
    if (std::isnan(t_min) || std::isnan(t_max)) refuse("t_min or t_max is no number");
    const planish_ray_answers to = taken(answers, planish_ray_answers_init, "answers");
    std::vector<std::optional<planish::SurfaceHit>> hits(count);
    run_on(queries->thread_count, [&] {
      planish::parallel_each(count, kQueryGrain, [&](std::size_t i) {
        hits[i] = queries->queries->first_hit(
            {vector_at(origins, i), vector_at(directions, i), t_min, t_max});
      });
    });
    for (std::size_t i = 0; i < count; ++i) answer(to, i, hits[i]);
    return PLANISH_OK;
  });
}
