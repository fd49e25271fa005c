#include <memory>

#include "planish/c/call.h"
#include "planish/c/handles.h"
#include "planish/c/planish.h"
#include "planish/pipeline/fit.h"
#include "planish/pipeline/tessellate_fit.h"

using namespace planish::c;

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
