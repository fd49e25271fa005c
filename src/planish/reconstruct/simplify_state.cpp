#include "planish/reconstruct/simplify_state.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "planish/core/host_scope.h"

namespace planish {
namespace {

// Longest to shortest edge at a vertex. Even: a Poisson-disk sampling has 2, but no collapse leads
// from one such sampling to a coarser one past vertices of a greater ratio. Adaptive: folds of the
// interpolating surface sit where edges of very different length meet.
constexpr double kEvenRatio = 2.6;
constexpr double kAdaptiveRatio = 5.2;
constexpr std::int64_t kStepsPerReport = 1 << 12;

}  // namespace

SimplifyState::SimplifyState(std::span<const glm::dvec3> given_positions,
                             std::span<const Triangle> triangles,
                             const SimplifyOptions& given_options)
    : positions(given_positions),
      options(given_options),
      mesh(triangles, positions.size()),
      judge(positions, triangles),
      gradation(positions, mesh, options.spacing == Spacing::Even ? kEvenRatio : kAdaptiveRatio),
      carried(positions, triangles.size(), options.tolerance),
      quadrics(positions.size()),
      due(positions.size(), 0) {
  const double degrees =
      options.least_angle < 0 ? default_least_angle(options.spacing) : options.least_angle;
  largest_cosine = std::cos(degrees * std::numbers::pi / 180);
  max_valence =
      options.max_valence < 0 ? default_max_valence(options.spacing) : options.max_valence;
  for (const Triangle& t : triangles) add_plane(t);
  std::vector<std::int32_t> loose;
  for (std::int32_t v = 0; v < static_cast<std::int32_t>(positions.size()); ++v) {
    if (mesh.is_used(v))
      touch(v);
    else
      loose.push_back(v);
  }
  result.strayed_count = carried.adopt(loose, triangles);
  initial_count_ = result.vertex_count = static_cast<std::int64_t>(positions.size() - loose.size());
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

void SimplifyState::count_step() {
  if (++steps_ % kStepsPerReport != 0) return;
  check_stop();
  options.callbacks.report("simplify",
                           1 - static_cast<double>(result.vertex_count) /
                                   static_cast<double>(std::max<std::int64_t>(initial_count_, 1)));
}

}  // namespace planish
