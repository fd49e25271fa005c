#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "planish/c/call.h"
#include "planish/c/handles.h"
#include "planish/c/planish.h"
#include "planish/core/formatted.h"
#include "planish/core/parallel.h"

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

using namespace planish::c;

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
