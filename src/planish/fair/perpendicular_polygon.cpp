// Names: e_i the edges' directions in the plane, s_i the weights with sum s_i e_i = 0, x_i the
// points: x_i - x_(i-1) = s_i e_i turned by a right angle.
#include "planish/fair/perpendicular_polygon.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "planish/fair/balanced_weights.h"
#include "planish/fair/vertex_frame.h"

namespace planish {

using glm::dvec2;
using glm::dvec3;

namespace {

// Of the least height of the faces around: a polygon of half of it stays off their other sides.
constexpr double kSize = 0.5;
constexpr double kHalf = 0.5;

// The height of a face over its longest side; polygons count half, as they narrow towards it.
double least_height(const FairTopology& topology, std::span<const dvec3> given, std::int32_t face) {
  const std::int32_t first = topology.face_offsets[face], m = topology.face_size(face);
  const dvec3& origin = given[topology.corner_vertices[first]];
  dvec3 area(0.0);  // twice
  double longest = 0;
  for (std::int32_t k = 0; k < m; ++k) {
    const dvec3 a = given[topology.corner_vertices[first + k]] - origin;
    const dvec3 b = given[topology.corner_vertices[first + (k + 1) % m]] - origin;
    area += glm::cross(a, b);
    longest = std::max(longest, glm::length(b - a));
  }
  if (!(longest > 0)) return 0;
  return glm::length(area) / longest / (m > 3 ? 2 : 1);
}

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

}  // namespace

double perpendicular_size(const FairTopology& topology, std::span<const dvec3> given,
                          std::int32_t vertex) {
  double least = HUGE_VAL;
  for (std::int32_t i = topology.ring_offsets[vertex]; i < topology.ring_offsets[vertex + 1]; ++i) {
    const double height =
        least_height(topology, given, topology.corner_faces[topology.ring_corners[i]]);
    if (height > 0) least = std::min(least, height);
  }
  return least < HUGE_VAL ? kSize * least : 0;
}

void build_perpendicular_polygon(const FairTopology& topology, std::span<const dvec3> given,
                                 std::int32_t vertex, const dvec3& normal,
                                 PerpendicularScratch& scratch, std::span<dvec3> offsets) {
  const std::int32_t first = topology.ring_offsets[vertex], n = topology.valence(vertex);
  const VertexFrame frame = frame_of(normal);
  scratch.edges.resize(static_cast<std::size_t>(n));
  scratch.points.resize(scratch.edges.size());
  scratch.weights.resize(scratch.edges.size());
  for (std::int32_t i = 0; i < n; ++i) {
    const dvec2 edge = frame.project(given[topology.ring_next[first + i]] - given[vertex]);
    const double length = glm::length(edge);
    scratch.edges[i] = length > 0 ? edge / length : dvec2(0.0);
  }
  double usable = balance(scratch.edges, scratch.weights);
  const double size = perpendicular_size(topology, given, vertex);
  const double farthest = usable > 0 ? set_points(scratch) : 0;
  if (!(farthest > 0) || !(size > 0)) usable = 0;
  for (std::int32_t i = 0; i < n; ++i) {
    dvec3& offset = offsets[topology.ring_corners[first + i]];
    offset *= kHalf * (1 - usable);
    if (!(usable > 0)) continue;
    const dvec2 point = usable * size / farthest * scratch.points[i];
    offset += point.x * frame.tangent1 + point.y * frame.tangent2;
  }
}

}  // namespace planish
