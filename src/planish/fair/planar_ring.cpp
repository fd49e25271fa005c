#include "planish/fair/planar_ring.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace planish {

using glm::dvec2;
using glm::dvec3;

namespace {

// A wedge narrower than this sine is a sliver: coordinates in it are noise.
constexpr double kSliverSine = 1e-3;
// A control point nearer to an edge of its wedge than this part of the other edge is not safely
// inside.
constexpr double kLeastInRing = 0.02;
constexpr double kRegularInRing = 1.0 / 6.0;

// Counts a coordinate from the least one on, so that the imbalance grows to infinity there instead
// of jumping; regular ones stay as they are.
double above_least(double coordinate) {
  constexpr double kScale = kRegularInRing / (kRegularInRing - kLeastInRing);
  return kScale * (coordinate - kLeastInRing);
}

double cross_of_plane(const dvec2& a, const dvec2& b) { return a.x * b.y - a.y * b.x; }

}  // namespace

PlanarRing::Wedge wedge_of(const dvec2& point, const dvec2& next, const dvec2& previous) {
  const double determinant = cross_of_plane(next, previous);
  const double size = std::sqrt(glm::dot(next, next) * glm::dot(previous, previous));
  if (!(determinant > kSliverSine * size)) return {0.0, 0.0, false};
  return {cross_of_plane(point, previous) / determinant, cross_of_plane(next, point) / determinant,
          true};
}

double wedge_share(const dvec2& next, const dvec2& previous) {
  const double size = std::sqrt(glm::dot(next, next) * glm::dot(previous, previous));
  if (!(size > 0)) return 0;
  return std::clamp(cross_of_plane(next, previous) / (kSliverSine * size) - 1, 0.0, 1.0);
}

void project_ring(std::span<const dvec3> given, std::span<const dvec3> corner_offsets,
                  std::int32_t vertex, const FairTopology::Ring& corners, const VertexFrame& frame,
                  PlanarRing& ring) {
  const std::int32_t count = corners.size();
  ring.count = count;
  if (ring.next.size() < static_cast<std::size_t>(count)) {
    ring.next.resize(static_cast<std::size_t>(count));
    ring.previous.resize(ring.next.size());
    ring.offsets.resize(ring.next.size());
    ring.wedges.resize(ring.next.size());
  }
  ring.mean = dvec2(0.0);
  for (std::int32_t i = 0; i < count; ++i) {
    ring.next[i] = frame.project(given[corners.next[i]] - given[vertex]);
    ring.previous[i] = frame.project(given[corners.previous[i]] - given[vertex]);
    ring.offsets[i] = frame.project(corner_offsets[corners.corners[i]]);
    ring.wedges[i] = wedge_of(ring.offsets[i], ring.next[i], ring.previous[i]);
    ring.mean += ring.offsets[i];
  }
  ring.mean /= count;
}

double imbalance(const PlanarRing& ring) {
  double worst = 0;
  for (std::int32_t i = 0; i < ring.count; ++i) {
    const PlanarRing::Wedge& own = ring.wedges[i];
    if (!own.valid || own.along_next <= kLeastInRing || own.along_previous <= kLeastInRing) {
      return std::numeric_limits<double>::infinity();
    }
    const PlanarRing::Wedge mean = wedge_of(ring.mean, ring.next[i], ring.previous[i]);
    const double ratio = std::max(std::abs(mean.along_next) / above_least(own.along_next),
                                  std::abs(mean.along_previous) / above_least(own.along_previous));
    // Straight corners too grow to infinity instead of jumping.
    worst = std::max(worst, ratio / wedge_share(ring.next[i], ring.previous[i]));
  }
  return worst;
}

}  // namespace planish
