#include "planish/fair/vertex_polygon.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "planish/core/portable_math.h"
#include "planish/core/work.h"
#include "planish/fair/fair_topology.h"

namespace planish {

using glm::dvec2;

namespace {

// Newton's method converges quadratically once near; six steps give what twelve do.
constexpr int kNewtonSteps = 6;
// Of y, in units of one over the points' rms length: longer ones overshoot the exponential.
constexpr double kLongestStep = 1.5;
// Keeps the Hessian invertible where all points lie on a line.
constexpr double kDamping = 1e-9;
// What may remain of the sum, as a part of the weights' sum; the centroid is made exact later. At
// twice this the weights are useless.
constexpr double kTolerance = 1e-3;
// Points that need a larger weight surround 0 only just; at twice this the weights are useless.
constexpr double kLargestWeight = 15.0;

// 1 up to the limit, falling to 0 at twice the limit.
double ramp(double value, double limit) { return std::clamp(2 - value / limit, 0.0, 1.0); }

// Sets weights[i] = exp(-y . points[i] * scale) and returns their sum.
double set_weights(std::span<const dvec2> points, const dvec2& y, std::span<double> weights) {
  double sum = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    weights[i] = portable::exp(-glm::dot(y, points[i]));
    sum += weights[i];
  }
  return sum;
}

}  // namespace

double balance(std::span<const dvec2> points, std::span<double> weights) {
  double square = 0;
  for (const dvec2& point : points) square += glm::dot(point, point);
  if (!(square > 0)) return 0;
  const double unit = static_cast<double>(points.size()) / square;  // 1 / rms^2

  // y is kept in units of 1 / length, so that no scaled copy of the points is needed.
  dvec2 y(0.0);
  std::fill(weights.begin(), weights.end(), 1.0);
  double sum = static_cast<double>(points.size());
  dvec2 moment(0.0);
  for (int step = 0;; ++step) {
    moment = dvec2(0.0);
    double xx = 0, xy = 0, yy = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const dvec2 weighted = weights[i] * points[i];
      moment += weighted;
      xx += weighted.x * points[i].x;
      xy += weighted.x * points[i].y;
      yy += weighted.y * points[i].y;
    }
    if (step == kNewtonSteps) break;
    xx += kDamping / unit;
    yy += kDamping / unit;
    const double determinant = xx * yy - xy * xy;
    if (!(determinant > 0)) return 0;
    dvec2 move(yy * moment.x - xy * moment.y, xx * moment.y - xy * moment.x);
    move /= determinant;
    const double length = std::sqrt(glm::dot(move, move) / unit);
    if (length > kLongestStep) move *= kLongestStep / length;
    y += move;
    sum = set_weights(points, y, weights);
  }
  const double largest = *std::max_element(weights.begin(), weights.end());
  const double left = std::sqrt(glm::dot(moment, moment) * unit) / sum;
  if (!std::isfinite(left) || !std::isfinite(largest)) return 0;
  return std::min(ramp(left, kTolerance), ramp(largest, kLargestWeight));
}

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

// Names: p_c ring.offsets (control points in the tangent plane), a_c and b_c the edges beside
// them, rho the imbalance, q_c the targets, s the balancing weights, d_c the polygon's points.

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

namespace {

// Cosine between the polygon's limit normal and the vertex's below which it counts as turned over.
constexpr double kReversedCosine = 0.2;
constexpr double kReversedFactor = 0.3;

dvec3 mean_of(const FairTopology& topology, std::span<const dvec3> offsets, std::int32_t vertex) {
  dvec3 sum(0.0);
  for (const std::int32_t corner : topology.ring(vertex).corners) sum += offsets[corner];
  return sum / static_cast<double>(topology.valence(vertex));
}

void centre(const FairTopology& topology, std::span<dvec3> offsets, std::int32_t vertex) {
  const dvec3 mean = mean_of(topology, offsets, vertex);
  for (const std::int32_t corner : topology.ring(vertex).corners) offsets[corner] -= mean;
}

bool is_reversed(const FairTopology& topology, std::span<const dvec3> offsets, std::int32_t vertex,
                 const dvec3& normal) {
  const auto corners = topology.ring(vertex).corners;
  const dvec3 own = limit_normal(topology, topology.valence(vertex),
                                 [&](std::int32_t i) { return offsets[corners[i]]; });
  return glm::dot(own, normal) < kReversedCosine * glm::length(own);
}

void build_local(const FairTopology& topology, std::span<const dvec3> given, std::int32_t vertex,
                 const PolygonShape& shape, PolygonScratch& scratch, std::span<dvec3> offsets) {
  const dvec3& normal = shape.normal;
  const FairTopology::Ring ring = topology.ring(vertex);
  const std::int32_t n = ring.size();
  const VertexFrame frame = frame_of(normal);
  project_ring(given, offsets, vertex, ring, frame, scratch.ring);
  build_local_polygon(scratch.ring, imbalance(scratch.ring), scratch.local);
  if (topology.is_regular[vertex] && !shape.is_flat) {
    scratch.heights.resize(static_cast<std::size_t>(n));
    for (std::int32_t i = 0; i < n; ++i) {
      scratch.heights[i] = glm::dot(offsets[ring.corners[i]], normal);
    }
    add_twist(scratch.ring, scratch.heights, scratch.local);
  }
  for (std::int32_t i = 0; i < n; ++i) {
    const glm::dvec2& flat = scratch.local.points[i];
    offsets[ring.corners[i]] =
        flat.x * frame.tangent1 + flat.y * frame.tangent2 + scratch.local.heights[i] * frame.normal;
  }
}

}  // namespace

bool build_vertex_polygon(const FairTopology& topology, std::span<const dvec3> given,
                          const GivenStep& step, std::int32_t vertex, const PolygonShape& shape,
                          PolygonScratch& scratch, std::span<dvec3> offsets) {
  const auto corners = topology.ring(vertex).corners;
  const std::int32_t n = topology.valence(vertex);
  // Two control points only: translation puts them on both sides of the vertex.
  const double share = n > 2 ? shape.share : 1.0;
  if (share > 0 && share < 1) {
    const dvec3 mean = mean_of(topology, offsets, vertex);
    scratch.translated.resize(static_cast<std::size_t>(n));
    for (std::int32_t i = 0; i < n; ++i) {
      scratch.translated[i] = offsets[corners[i]] - mean;
    }
  }
  if (share < 1) build_local(topology, given, vertex, shape, scratch, offsets);
  if (share > 0 && share < 1) {
    for (std::int32_t i = 0; i < n; ++i) {
      dvec3& offset = offsets[corners[i]];
      offset = share * scratch.translated[i] + (1 - share) * offset;
    }
  }
  const bool reversed =
      shape.reversed ? *shape.reversed : is_reversed(topology, offsets, vertex, shape.normal);
  if (reversed) {
    for (const std::int32_t corner : corners)
      offsets[corner] = kReversedFactor * step.offset(corner);
  }
  centre(topology, offsets, vertex);
  return reversed;
}

namespace {

// A handle may pass the shorter arm by this factor.
constexpr double kLongestHandle = 1.15;
// How far a handle may lead into a face: of the way that the corner's own control point is from the
// curve, and of the other edge's distance, which is the same in a parallelogram.
constexpr double kCorridor = 0.5, kCorridorOfEdge = 1.0 / 8.0;
constexpr double kLeastCorridorFactor = 0.02;

// Wider corners than of 174 degrees in a triangle count as that: the handle does not run into what
// lies behind it, and polygons' corners pass through 180 degrees.
constexpr double kWidestSine = 0.1 / 6;

// The factor in one face, between its sharp edge and its other one; `inward` is in the face and at
// right angles to the sharp edge, `point` the corner's control point.
double face_factor(const dvec3& handle, const dvec3& sharp, const dvec3& inward, const dvec3& other,
                   const dvec3& point) {
  const double lateral = glm::dot(handle, inward);
  double most =
      std::min(kCorridor * glm::dot(point, inward), kCorridorOfEdge * glm::dot(other, inward));
  if (glm::dot(other, sharp) < 0 || glm::dot(other, inward) < 0)
    most = std::max(most, kCorridor * kWidestSine * glm::length(other));
  return most > 0 && lateral > most ? most / lateral : 1.0;
}

}  // namespace

CreaseArms crease_arms(const FairTopology& topology, std::span<const dvec3> given,
                       std::int32_t vertex) {
  const auto [before, after] = topology.crease_neighbours(vertex);
  return {(given[before] - given[vertex]) / 4.0, (given[after] - given[vertex]) / 4.0};
}

double imbalance(const CreaseArms& arms) {
  const double before = glm::length(arms.before), after = glm::length(arms.after);
  const double shorter = std::min(before, after);
  if (!(shorter > 0)) return std::numeric_limits<double>::infinity();
  return std::abs(before - after) / shorter;
}

double corridor_factor(const FairTopology& topology, std::span<const dvec3> given,
                       const GivenStep& step, std::span<const dvec3> face_normals,
                       std::int32_t vertex, const dvec3& handle) {
  const std::int32_t before = topology.crease_neighbours(vertex)[0];
  double factor = 1;
  const FairTopology::Ring ring = topology.ring(vertex);
  for (std::int32_t i = 0; i < ring.size(); ++i) {
    const std::int32_t corner = ring.corners[i];
    const dvec3 next = given[ring.next[i]] - given[vertex];
    const dvec3 previous = given[ring.previous[i]] - given[vertex];
    const dvec3& normal = face_normals[topology.corner_faces[corner]];
    const auto note = [&](std::int32_t neighbour, const dvec3& sharp, const dvec3& inward,
                          const dvec3& other) {
      const double length = glm::length(inward);
      if (!(length > 0)) return;
      const dvec3 along = neighbour == before ? handle : -handle;
      factor =
          std::min(factor, face_factor(along, sharp, inward / length, other, step.offset(corner)));
    };
    if (topology.corner_cw[corner] >= topology.corner_count) {
      note(ring.next[i], next, glm::cross(normal, next), previous);
    }
    if (topology.corner_ccw[corner] >= topology.corner_count) {
      note(ring.previous[i], previous, glm::cross(previous, normal), next);
    }
  }
  return std::max(factor, kLeastCorridorFactor);
}

dvec3 crease_handle(const CreaseArms& arms) {
  const double before = glm::length(arms.before), after = glm::length(arms.after);
  if (!(before > 0) || !(after > 0)) return dvec3(0.0);
  const dvec3 direction = arms.before / (before * before) - arms.after / (after * after);
  const double length = glm::length(direction);
  if (!(length > 0)) return dvec3(0.0);  // a cusp: both arms the same way
  return direction *
         (std::min((before + after) / 2, kLongestHandle * std::min(before, after)) / length);
}

namespace {

// Control points beside a sharp edge follow its handle, but not farther than this factor.
constexpr double kLongestInSector = 1.3;

VertexFrame sector_frame(const FairTopology& topology, std::span<const dvec3> given,
                         std::span<const dvec3> face_normals, const FairTopology::Sector& sector,
                         const SectorShape& shape) {
  const dvec3& handle = shape.handle;
  const dvec3 normal = shape.normal ? *shape.normal
                                    : angle_weighted_normal(topology, given, face_normals,
                                                            sector.vertex, topology.ring(sector));
  const double square = glm::dot(handle, handle);
  if (!(square > 0)) return frame_of(normal);
  const dvec3 upright = normal - glm::dot(normal, handle) / square * handle;
  const double length = glm::length(upright);
  constexpr double kParallel = 1e-6;  // the handle stands on the sector: no plane holds both
  return frame_of(length > kParallel ? upright / length : normal);
}

double handle_factor(double handle_length, const dvec3& edge) {
  const double arm = glm::length(edge) / 4.0;
  return arm > 0 ? std::min(kLongestInSector, handle_length / arm) : 1.0;
}

// How far a control point at `coordinate` of the edge goes along with its handle. Deep in a large
// face, where the edge's own length is little, it stays in the order of the face's others.
double moved(double factor, double coordinate) {
  return (factor - 1) * coordinate * std::clamp(2 - std::abs(coordinate), 0.0, 1.0);
}

}  // namespace

void build_sector(const FairTopology& topology, std::span<const dvec3> given, const GivenStep& step,
                  std::span<const dvec3> face_normals, const FairTopology::Sector& sector,
                  const SectorShape& shape, std::span<dvec3> offsets) {
  const VertexFrame frame = sector_frame(topology, given, face_normals, sector, shape);
  const double handle_length = glm::length(shape.handle);
  const FairTopology::Ring ring = topology.ring(sector);
  for (std::int32_t i = 0; i < sector.count; ++i) {
    const std::int32_t corner = ring.corners[i];
    const dvec3 next = given[ring.next[i]] - given[sector.vertex];
    const dvec3 previous = given[ring.previous[i]] - given[sector.vertex];
    const dvec2 flat_next = frame.project(next), flat_previous = frame.project(previous);
    dvec2 flat = frame.project(step.offset(corner));
    const PlanarRing::Wedge wedge = wedge_of(flat, flat_next, flat_previous);
    if (wedge.valid) {
      const double next_factor = i == 0 ? handle_factor(handle_length, next) : 1.0;
      const double previous_factor =
          i + 1 == sector.count ? handle_factor(handle_length, previous) : 1.0;
      flat += wedge_share(flat_next, flat_previous) *
              (moved(next_factor, wedge.along_next) * flat_next +
               moved(previous_factor, wedge.along_previous) * flat_previous);
    }
    offsets[corner] = shape.share * (offsets[corner] + shape.tensor_shift) +
                      (1 - shape.share) * (flat.x * frame.tangent1 + flat.y * frame.tangent2);
  }
}

namespace {

// Imbalance from which the share falls below 1, and where it reaches 0: at 1 translation would put
// a control point on the edge of its wedge.
constexpr double kFullShareBelow = 0.4;
constexpr double kNoShareFrom = 0.9;
// Where neighbours move together they do not meet, but not all neighbours are asked: such an
// imbalance counts this much.
constexpr double kRelativeWeight = 2.0;

// Faces around a vertex from which on its error is made once.
constexpr std::int32_t kHubValence = 64;

// How far the limit point moves beyond those of its neighbours. Where a row of quads bends in its
// tangent plane all of them move together, far out of narrow wedges, and nothing folds.
dvec3 relative_error(const GivenErrors& errors, std::int32_t vertex) {
  dvec3 around(0.0);
  for (const std::int32_t other : errors.topology.ring(vertex).next) around += errors.of(other);
  return errors.of(vertex) - around / static_cast<double>(errors.topology.valence(vertex));
}

double share_of(double rho) {
  return std::clamp((kNoShareFrom - rho) / (kNoShareFrom - kFullShareBelow), 0.0, 1.0);
}

}  // namespace

GivenErrors::GivenErrors(const FairTopology& of, std::span<const dvec3> points,
                         std::span<const dvec3> offsets)
    : topology(of), given(points), corner_offsets(offsets) {
  for (std::int32_t v = 0; v < topology.vertex_count; ++v)
    if (is_hub(v)) of_hubs_.emplace(v, made(v));
}

bool GivenErrors::is_hub(std::int32_t vertex) const {
  return topology.valence(vertex) >= kHubValence;
}

dvec3 GivenErrors::made(std::int32_t vertex) const {
  if (is_hub(vertex)) count_work(Work::Points, topology.valence(vertex));
  return limit_error(topology, given, given, corner_offsets, vertex);
}

dvec3 GivenErrors::of(std::int32_t vertex) const {
  return is_hub(vertex) ? of_hubs_.at(vertex) : made(vertex);
}

double tensor_share(const GivenErrors& errors, const dvec3& normal, std::int32_t vertex,
                    PlanarRing& scratch) {
  const FairTopology& topology = errors.topology;
  if (!topology.is_regular[vertex] || topology.kind(vertex) == VertexKind::Corner) return 0;
  if (topology.kind(vertex) == VertexKind::Crease) {
    return share_of(imbalance(crease_arms(topology, errors.given, vertex)));
  }
  const VertexFrame frame = frame_of(normal);
  project_ring(errors.given, errors.corner_offsets, vertex, topology.ring(vertex), frame, scratch);
  const double rho = imbalance(scratch);
  if (rho <= kFullShareBelow) return 1;
  scratch.mean = frame.project(relative_error(errors, vertex));
  return share_of(std::min(rho, kRelativeWeight * imbalance(scratch)));
}

}  // namespace planish
