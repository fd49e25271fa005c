#include "planish/reconstruct/simplify_state.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <utility>

#include "planish/core/host_scope.h"
#include "planish/core/parallel.h"
#include "planish/core/stop.h"

namespace planish {
namespace {

// Longest to shortest edge at a vertex. Even: a Poisson-disk sampling has 2, but no collapse leads
// from one such sampling to a coarser one past vertices of a greater ratio. Adaptive: folds of the
// interpolating surface sit where edges of very different length meet.
constexpr double kEvenRatio = 2.6;
constexpr double kAdaptiveRatio = 5.2;
constexpr std::int64_t kStepsPerReport = 1 << 12, kStepsPerLook = 1 << 4;

std::vector<glm::dvec3> places_of(const OrderedPoints& points,
                                  std::span<const std::int32_t> chosen) {
  std::vector<glm::dvec3> places;
  places.reserve(chosen.size());
  for (const std::int32_t point : chosen) places.push_back(points[point]);
  return places;
}

}  // namespace

SimplifyState::SimplifyState(const OrderedPoints& given_points, WitnessedMesh witnessed,
                             const SimplifyOptions& given_options)
    : points(given_points),
      options(given_options),
      vertex_points(std::move(witnessed.vertex_points)),
      positions(places_of(points, vertex_points)),
      mesh(witnessed.triangles, positions.size()),
      judge(positions, witnessed.triangles),
      gradation(positions, mesh, options.spacing == Spacing::Even ? kEvenRatio : kAdaptiveRatio),
      point_normals(normals_of_points(witnessed)),
      carried(points, positions, vertex_points, witnessed.carriers, witnessed.triangles.size(),
              options.tolerance),
      quadrics(positions.size()),
      due(positions.size(), 0) {
  const double degrees =
      options.least_angle < 0 ? default_least_angle(options.spacing) : options.least_angle;
  largest_cosine = std::cos(degrees * std::numbers::pi / 180);
  max_valence =
      options.max_valence < 0 ? default_max_valence(options.spacing) : options.max_valence;
  for (const Triangle& t : witnessed.triangles) add_plane(t);
  for (std::int32_t v = 0; v < static_cast<std::int32_t>(positions.size()); ++v) touch(v);
  result.vertex_count = std::ssize(positions);
}

std::vector<PackedNormal> SimplifyState::normals_of_points(const WitnessedMesh& witnessed) const {
  std::vector<PackedNormal> normals(points.size());
  parallel_each(points.size(), [&](std::size_t point) {
    if (witnessed.carriers[point] < 0) return;
    const Triangle& t = witnessed.triangles[witnessed.carriers[point]];
    const glm::dvec3 share =
        TriangleShape(positions[t[0]], positions[t[1]], positions[t[2]]).shares(points[point]);
    normals[point] = PackedNormal(share[0] * judge.normal(t[0]) + share[1] * judge.normal(t[1]) +
                                  share[2] * judge.normal(t[2]));
  });
  for (std::size_t v = 0; v < vertex_points.size(); ++v)
    normals[vertex_points[v]] = PackedNormal(judge.normal(static_cast<std::int32_t>(v)));
  return normals;
}

void SimplifyState::add_plane(const Triangle& t) {
  const glm::dvec3 cross =
      glm::cross(positions[t[1]] - positions[t[0]], positions[t[2]] - positions[t[0]]);
  const double length = glm::length(cross);
  if (!(length > 0)) return;
  for (const std::int32_t corner : t)
    quadrics[corner].add_plane(cross / length, positions[t[0]], length);
}

bool SimplifyState::take(std::int32_t vertex, Pass pass) {
  if (!waits(vertex, pass) || !mesh.is_used(vertex)) return false;
  due[vertex] = static_cast<std::uint8_t>(due[vertex] & ~static_cast<std::uint8_t>(pass));
  return true;
}

TriangleQuality SimplifyState::worst_of(const Fan& fan) const {
  TriangleQuality worst;
  for (const std::int32_t spoke : fan.spokes) {
    const Triangle t = mesh.triangle(spoke / 3);
    worst.take_worst(judge.quality(t[0], t[1], t[2]));
  }
  return worst;
}

void SimplifyState::begin_round(double begin, double end) {
  round_begin_ = begin;
  round_end_ = end;
  round_count_ = result.vertex_count;
  options.callbacks.report("simplify", begin);
}

void SimplifyState::count_step() {
  // A step looks at the points of all triangles around a vertex: thousands in a dense cloud.
  if (++steps_ % kStepsPerLook == 0) check_stop();
  if (steps_ % kStepsPerReport != 0) return;
  const double left = static_cast<double>(result.vertex_count) /
                      static_cast<double>(std::max<std::int64_t>(round_count_, 1));
  options.callbacks.report("simplify", std::lerp(round_end_, round_begin_, left));
}

}  // namespace planish
