// Names: e_i the edges' directions in the plane, s_i the weights with sum s_i e_i = 0, x_i the
// points: x_i - x_(i-1) = s_i e_i turned by a right angle.
#include "planish/fair/perpendicular_polygon.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "planish/fair/balanced_weights.h"
#include "planish/fair/plane_lean.h"
#include "planish/fair/vertex_frame.h"

namespace planish {

using glm::dvec2;
using glm::dvec3;

namespace {

// Of the least height of the faces around: a polygon of half of it stays off their other sides.
constexpr double kSize = 0.5;
// Of how far the weights are to be used: from here on they are all there is.
constexpr double kFullChain = 0.05;

// The points about their mean; returns the farthest one's distance.
double set_points(PerpendicularScratch& scratch) {
  dvec2 at(0.0), mean(0.0);
  const std::size_t n = scratch.edges.size();
  for (std::size_t i = 0; i < n; ++i) {
    at += scratch.weights[i] * dvec2(-scratch.edges[i].y, scratch.edges[i].x);
    scratch.points[i] = at;
    mean += at;
  }
  mean /= static_cast<double>(n);
  double farthest = 0;
  for (dvec2& point : scratch.points) {
    point -= mean;
    farthest = std::max(farthest, glm::length(point));
  }
  return farthest;
}

// As complex numbers.
dvec2 rotated(const dvec2& point, const dvec2& by) {
  return {point.x * by.x - point.y * by.y, point.x * by.y + point.y * by.x};
}

// Where on the circle the first of evenly spread points lies: half a step beyond where the edges
// point to, so that the points stand near to the bisectors of their faces.
dvec2 circle_start(const dvec2& direction, std::int32_t count) {
  const double half_step = std::numbers::pi / count;
  return rotated(direction, {std::cos(half_step), std::sin(half_step)});
}

}  // namespace

double chain_share(double usable) { return std::min(1.0, usable / kFullChain); }

FaceHeights::FaceHeights(const FairTopology& topology, std::span<const dvec3> given)
    : topology_(topology), given_(given) {
  for (const std::int32_t face : topology.large_faces) of_large_.push_back(measured(face));
}

double FaceHeights::measured(std::int32_t face) const {
  const std::int32_t first = topology_.face_offsets[face], m = topology_.face_size(face);
  const dvec3& origin = given_[topology_.corner_vertices[first]];
  dvec3 area(0.0);  // twice
  double longest = 0;
  for (std::int32_t k = 0; k < m; ++k) {
    const dvec3 a = given_[topology_.corner_vertices[first + k]] - origin;
    const dvec3 b = given_[topology_.corner_vertices[first + (k + 1) % m]] - origin;
    area += glm::cross(a, b);
    longest = std::max(longest, glm::length(b - a));
  }
  if (!(longest > 0)) return 0;
  return glm::length(area) / longest / (m > 3 ? 2 : 1);
}

double FaceHeights::of(std::int32_t face) const {
  const std::int32_t large = topology_.large_face(face);
  return large < 0 ? measured(face) : of_large_[large];
}

double FaceHeights::size_at(std::int32_t vertex) const {
  double least = HUGE_VAL;
  for (const std::int32_t corner : topology_.ring(vertex).corners) {
    const double height = of(topology_.corner_faces[corner]);
    if (height > 0) least = std::min(least, height);
  }
  return least < HUGE_VAL ? kSize * least : 0;
}

void build_perpendicular_polygon(const FairTopology& topology, std::span<const dvec3> given,
                                 std::int32_t vertex, const dvec3& normal, double size,
                                 PerpendicularScratch& scratch, std::span<dvec3> offsets) {
  const FairTopology::Ring ring = topology.ring(vertex);
  const std::int32_t n = ring.size();
  const VertexFrame frame = frame_of(normal);
  scratch.edges.resize(static_cast<std::size_t>(n));
  scratch.points.resize(scratch.edges.size());
  scratch.weights.resize(scratch.edges.size());
  for (std::int32_t i = 0; i < n; ++i) {
    const dvec2 edge = frame.project(given[ring.next[i]] - given[vertex]);
    const double length = glm::length(edge);
    scratch.edges[i] = length > 0 ? edge / length : dvec2(0.0);
  }
  const double usable = balance(scratch.edges, scratch.weights);
  const double farthest = usable > 0 ? set_points(scratch) : 0;
  const double chain = farthest > 0 ? chain_share(usable) : 0;
  // As far as the edges do not surround the vertex, the points of a circle: its sides cross no
  // edges at right angles, but the limit normal is the plane's.
  const dvec2 start =
      chain < 1 ? circle_start(ring_direction(topology, given, vertex, frame), n) : dvec2(0.0);
  const auto circle = topology.unit_circle.of(n);
  for (std::int32_t i = 0; i < n; ++i) {
    dvec2 point = (1 - chain) * size * rotated(start, circle[i]);
    if (chain > 0) point += chain * size / farthest * scratch.points[i];
    offsets[ring.corners[i]] = point.x * frame.tangent1 + point.y * frame.tangent2;
  }
}

}  // namespace planish
