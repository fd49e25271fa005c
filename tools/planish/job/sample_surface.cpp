#include "job/sample_surface.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "make_scenes/sample_points.h"
#include "planish/backend/cpu_backend.h"
#include "planish/core/stop.h"
#include "planish/limit/surface_queries.h"
#include "planish/pipeline/fit.h"
#include "planish/surface/doo_sabin_surface.h"
#include "planish/surface/surface_blocks.h"

namespace planish::command {
namespace {

constexpr int kSampledLevel = 2;

PolygonMesh tessellation_of(const DooSabinSurface& exact, const Callbacks& callbacks) {
  const SurfaceMesh surface = collect(*exact.level(kSampledLevel), callbacks);
  PolygonMesh result;
  result.positions.assign(surface.positions.begin(), surface.positions.end());
  for (std::int64_t f = 0; f < surface.face_count(); ++f) result.add_face(surface.face(f));
  return result;
}

// From near a surface onto it.
void move_onto(std::unique_ptr<const DooSabinSurface> surface, std::span<glm::dvec3> points) {
  const LimitSurface limit(std::move(surface));
  const SurfaceQueries queries(limit);
  std::vector<ClosestPoint> closest(points.size());
  queries.closest(points, closest);
  std::ranges::transform(closest, points.begin(), &ClosestPoint::position);
}

}  // namespace

PointCloud sample_surface(const Input& input, const Sampling& sampling,
                          const Callbacks& callbacks) {
  const PolygonMesh& mesh = input.file.mesh;
  const auto backend = make_cpu_backend({Precision::Double, 0});
  const Fit fitted = fit(mesh, *backend, {.callbacks = callbacks});
  auto exact = fitted_surface(mesh, fitted);
  const PolygonMesh surface = tessellation_of(*exact, callbacks);
  callbacks.report("sample", 0.0);
  const auto count = static_cast<std::int32_t>(sampling.points);
  std::vector<glm::dvec3> points = sampling.poisson_disk
                                       ? shapes::sample_poisson_disk(surface, count, sampling.seed)
                                       : shapes::sample_uniform(surface, count, sampling.seed);
  move_onto(std::move(exact), points);
  // Each a seed of its own, so that noise and outliers have nothing to do with the places.
  if (sampling.noise > 0)
    shapes::add_noise(points, sampling.noise * diagonal_of(points), sampling.seed + 1);
  const auto outliers = static_cast<std::int32_t>(std::lround(sampling.outliers * count));
  shapes::add_outliers(points, outliers, sampling.seed + 2);
  check_stop();
  callbacks.report("sample", 1.0);
  return cloud_of(std::move(points), input.name);
}

}  // namespace planish::command
