// Names: p_c ring.offsets (control points in the tangent plane), a_c and b_c the edges beside
// them, rho the imbalance, q_c the targets, s the balancing weights, d_c the polygon's points.
#include "planish/fair/local_polygon.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "planish/fair/balanced_weights.h"

namespace planish {

using glm::dvec2;

namespace {

// Up to this imbalance translation alone keeps every control point well inside its wedge; beyond
// it, translation takes this much of the wedge and factors do the rest.
constexpr double kTranslatedImbalance = 0.5;
// Control points may move away from the vertex by this factor: farther ones meet their neighbours'.
constexpr double kLongestFactor = 1.15;
// Control points this near to an edge of their wedge give no direction to balance along.
constexpr double kLeastCoordinate = 0.01;
constexpr double kRegularCoordinate = 1.0 / 6.0;
// Where nothing balances: small enough to stay clear of the neighbours' polygons.
constexpr double kLastResortFactor = 0.15;

void resize(LocalPolygon& polygon, std::int32_t count) {
  if (polygon.points.size() >= static_cast<std::size_t>(count)) return;
  polygon.points.resize(static_cast<std::size_t>(count));
  polygon.heights.resize(polygon.points.size());
  polygon.targets.resize(polygon.points.size());
  polygon.shares.resize(polygon.points.size());
  polygon.blended.resize(polygon.points.size());
}

void limit_length(std::int32_t count, LocalPolygon& polygon) {
  double largest = 0;  // square of the factor
  for (std::int32_t i = 0; i < count; ++i) {
    const double target = glm::dot(polygon.targets[i], polygon.targets[i]);
    if (target > 0) {
      largest = std::max(largest, glm::dot(polygon.points[i], polygon.points[i]) / target);
    }
  }
  if (largest <= kLongestFactor * kLongestFactor) return;
  const double scale = kLongestFactor / std::sqrt(largest);
  for (std::int32_t i = 0; i < count; ++i) polygon.points[i] *= scale;
}

// d_c = s_c q_c. Returns how far that is to be used, as balance() does.
double balance_corners(const PlanarRing& ring, double rho, LocalPolygon& polygon) {
  const auto n = static_cast<std::size_t>(ring.count);
  for (std::size_t i = 0; i < n; ++i) {
    polygon.targets[i] = ring.offsets[i] - kTranslatedImbalance / rho * ring.mean;
  }
  const auto shares = std::span(polygon.shares).first(n);
  const double usable = balance(std::span(polygon.targets).first(n), shares);
  for (std::size_t i = 0; i < n; ++i) polygon.points[i] = shares[i] * polygon.targets[i];
  if (usable > 0) limit_length(ring.count, polygon);
  return usable;
}

// Regular coordinates instead of those that give no direction, and of the first ones beyond these a
// part, so that nothing jumps.
PlanarRing::Wedge usable_wedge(const PlanarRing& ring, std::size_t i) {
  const PlanarRing::Wedge& wedge = ring.wedges[i];
  if (!wedge.valid) return {kRegularCoordinate, kRegularCoordinate, true};
  const double least = std::min(wedge.along_next, wedge.along_previous);
  const double share = std::clamp(least / kLeastCoordinate - 1, 0.0, 1.0) *
                       wedge_share(ring.next[i], ring.previous[i]);
  if (!(share > 0)) return {kRegularCoordinate, kRegularCoordinate, true};
  return {kRegularCoordinate + share * (wedge.along_next - kRegularCoordinate),
          kRegularCoordinate + share * (wedge.along_previous - kRegularCoordinate), true};
}

// The same on edges, which surround the vertex more evenly: each edge takes the parts of its two
// control points along it and gets one factor.
double balance_edges(const PlanarRing& ring, LocalPolygon& polygon) {
  const auto n = static_cast<std::size_t>(ring.count);
  for (std::size_t i = 0; i < n; ++i) {
    const PlanarRing::Wedge own = usable_wedge(ring, i);
    const PlanarRing::Wedge before = usable_wedge(ring, (i + n - 1) % n);
    polygon.targets[i] = (own.along_next + before.along_previous) * ring.next[i];
  }
  const auto shares = std::span(polygon.shares).first(n);
  const double usable = balance(std::span(polygon.targets).first(n), shares);
  for (std::size_t i = 0; i < n; ++i) {
    const PlanarRing::Wedge own = usable_wedge(ring, i);
    polygon.points[i] = shares[i] * own.along_next * ring.next[i] +
                        shares[(i + 1) % n] * own.along_previous * ring.previous[i];
    polygon.targets[i] = own.along_next * ring.next[i] + own.along_previous * ring.previous[i];
  }
  if (usable > 0) limit_length(ring.count, polygon);
  return usable;
}

// Adds `part` of the points, where it is any, to the blend.
void add_part(std::int32_t count, double part, LocalPolygon& polygon) {
  if (!(part > 0)) return;  // points that are not to be used may be no numbers
  for (std::int32_t i = 0; i < count; ++i) polygon.blended[i] += part * polygon.points[i];
}

}  // namespace

void build_local_polygon(const PlanarRing& ring, double rho, LocalPolygon& polygon) {
  resize(polygon, ring.count);
  std::fill_n(polygon.heights.begin(), ring.count, 0.0);
  if (rho <= kTranslatedImbalance) {
    for (std::int32_t i = 0; i < ring.count; ++i) polygon.points[i] = ring.offsets[i] - ring.mean;
    return;
  }
  const double by_corners = balance_corners(ring, rho, polygon);
  if (by_corners == 1) return;
  std::fill_n(polygon.blended.begin(), ring.count, dvec2(0.0));
  add_part(ring.count, by_corners, polygon);
  const double by_edges = (1 - by_corners) * balance_edges(ring, polygon);
  add_part(ring.count, by_edges, polygon);
  const double rest = (1 - by_corners - by_edges) * kLastResortFactor;
  for (std::int32_t i = 0; i < ring.count; ++i) {
    polygon.points[i] = polygon.blended[i] + rest * ring.offsets[i];
  }
}

void add_twist(const PlanarRing& ring, std::span<const double> heights, LocalPolygon& polygon) {
  double mean = 0;
  for (std::int32_t i = 0; i < ring.count; ++i) mean += heights[i];
  mean /= ring.count;
  // Least squares of a plane over the control points about their mean.
  double xx = 0, xy = 0, yy = 0;
  dvec2 moment(0.0);
  for (std::int32_t i = 0; i < ring.count; ++i) {
    const dvec2 p = ring.offsets[i] - ring.mean;
    xx += p.x * p.x;
    xy += p.x * p.y;
    yy += p.y * p.y;
    moment += (heights[i] - mean) * p;
  }
  const double determinant = xx * yy - xy * xy;
  constexpr double kFlat = 1e-12;  // control points on a line: no plane is better than another
  dvec2 slope(0.0);
  if (determinant > kFlat * (xx + yy) * (xx + yy)) {
    slope = dvec2(yy * moment.x - xy * moment.y, xx * moment.y - xy * moment.x) / determinant;
  }
  for (std::int32_t i = 0; i < ring.count; ++i) {
    const double twist = heights[i] - mean - glm::dot(slope, ring.offsets[i] - ring.mean);
    const double before = glm::length(ring.offsets[i]);
    const double after = glm::length(polygon.points[i]);
    polygon.heights[i] = twist * (after < before ? after / before : 1.0);
  }
}

}  // namespace planish
