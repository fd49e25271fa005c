#include "planish/fair/net_samples.h"

#include <algorithm>
#include <glm/geometric.hpp>

#include "planish/core/parallel.h"
#include "planish/core/work.h"
#include "planish/fair/limit_normal.h"

namespace planish {

using glm::dvec3;

namespace {

// A step of Doo-Sabin on one polygon, about its first point.
template <class Point>
dvec3 stepped(const FairTopology& topology, std::int32_t count, const Point& point) {
  const auto circle = topology.unit_circle.of(count);
  const dvec3 own = point(0);
  dvec3 sum(0.0);
  for (std::int32_t k = 1; k < count; ++k) sum += (3 + 2 * circle[k].x) * (point(k) - own);
  return own + sum / (4.0 * count);
}

// Sums of a large polygon, of which a step takes few.
template <class Point>
NetSamples::PolygonSums sums_of(const FairTopology& topology, std::int32_t count,
                                const Point& point) {
  const auto circle = topology.unit_circle.of(count);
  const dvec3 origin = point(0);
  NetSamples::PolygonSums sums{};
  for (std::int32_t k = 1; k < count; ++k) {
    const dvec3 from_origin = point(k) - origin;
    sums.mean += from_origin;
    sums.even += circle[k].x * from_origin;
    sums.odd += circle[k].y * from_origin;
  }
  sums.mean = origin + sums.mean / double(count);
  sums.even *= 2.0 / count;
  sums.odd *= 2.0 / count;
  return sums;
}

// X_i / 4 + 3/4 M + (cos a_i U + sin a_i W) / 4.
dvec3 stepped(const NetSamples::PolygonSums& sums, const dvec3& own, const glm::dvec2& place) {
  return 0.25 * own + 0.75 * sums.mean + 0.25 * (place.x * sums.even + place.y * sums.odd);
}

// The same on four points.
dvec3 stepped_quad(const dvec3& own, const dvec3& beside, const dvec3& opposite,
                   const dvec3& other_beside) {
  return own + (3.0 * (beside - own) + 3.0 * (other_beside - own) + (opposite - own)) / 16.0;
}

}  // namespace

double cosine_of(const dvec3& normal, const dvec3& reference) {
  const double length = glm::length(normal);
  return length > 0 ? glm::dot(normal, reference) / length : -1;
}

dvec3 NetSamples::at_edge(const FairTopology::Edge& edge) const {
  return glm::cross(point(edge.corners[2]) - point(edge.corners[0]),
                    point(edge.corners[3]) - point(edge.corners[1]));
}

dvec3 NetSamples::at_face(std::int32_t face) const {
  const std::int32_t first = topology.face_offsets[face];
  return limit_normal(topology, topology.face_size(face),
                      [&](std::int32_t i) { return point(first + i); });
}

dvec3 NetSamples::at_vertex(std::int32_t vertex) const {
  const auto corners = topology.ring(vertex).corners;
  return limit_normal(topology, topology.valence(vertex),
                      [&](std::int32_t i) { return offsets[corners[i]]; });
}

namespace {

// The points of level 2 around one control point, and the control points beside it.
struct Surroundings {
  const NetSamples& samples;
  const FairTopology& topology = samples.topology;
  const NetSamples::PolygonSums* of_polygon = nullptr;  // around the vertex, where that is large
  mutable std::int64_t asked = 0;                       // points of polygons

  ~Surroundings() { count_work(Work::Points, asked); }

  [[nodiscard]] std::int32_t beside(std::int32_t corner, std::int32_t by) const {
    const std::int32_t face = topology.corner_faces[corner], m = topology.face_size(face);
    const std::int32_t first = topology.face_offsets[face];
    return first + (corner - first + by + m) % m;
  }
  // Whether the edge from one corner to the next one of its face is. A dart's ring does not show
  // that it has a sharp one.
  [[nodiscard]] bool is_smooth(std::int32_t corner, std::int32_t next) const {
    return topology.corner_cw[corner] < topology.corner_count &&
           topology.corner_ccw[next] < topology.corner_count;
  }
  [[nodiscard]] dvec3 in_face(std::int32_t corner) const {
    const std::int32_t face = topology.corner_faces[corner], m = topology.face_size(face);
    if (const std::int32_t large = topology.large_face(face); large >= 0)
      return stepped(samples.of_large_faces[large], samples.point(corner),
                     topology.unit_circle.of(m)[corner - topology.face_offsets[face]]);
    asked += m;
    return stepped(topology, m, [&](std::int32_t k) { return samples.point(beside(corner, k)); });
  }
  [[nodiscard]] dvec3 in_polygon(std::int32_t vertex, std::int32_t place) const {
    const FairTopology::Ring ring = topology.ring(vertex);
    if (of_polygon) {
      const std::int32_t at = place % ring.size();
      return stepped(*of_polygon, samples.point(ring.corners[at]),
                     topology.unit_circle.of(ring.size())[at]);
    }
    asked += ring.size();
    return stepped(topology, ring.size(), [&](std::int32_t k) {
      return samples.point(ring.corners[(place + k) % ring.size()]);
    });
  }
  // In the polygon of the edge to the next vertex of the face, and to the one before.
  [[nodiscard]] dvec3 on_next(std::int32_t corner) const {
    const std::int32_t other = topology.corner_cw[corner];
    return stepped_quad(samples.point(corner), samples.point(beside(corner, 1)),
                        samples.point(beside(other, -1)), samples.point(other));
  }
  [[nodiscard]] dvec3 on_previous(std::int32_t corner) const {
    const std::int32_t other = topology.corner_ccw[corner];
    return stepped_quad(samples.point(corner), samples.point(beside(corner, -1)),
                        samples.point(beside(other, 1)), samples.point(other));
  }
};

}  // namespace

void NetSamples::sum_large_faces() {
  of_large_faces.resize(topology.large_faces.size());
  parallel_each(of_large_faces.size(), 1, [&](std::size_t i) {
    const std::int32_t face = topology.large_faces[i];
    const std::int32_t first = topology.face_offsets[face];
    of_large_faces[i] = sums_of(topology, topology.face_size(face),
                                [&](std::int32_t k) { return point(first + k); });
  });
}

double NetSamples::least_cosine_around(std::int32_t vertex,
                                       std::span<const dvec3> face_normals) const {
  PolygonSums sums{};
  Surroundings around{*this};
  if (topology.valence(vertex) >= topology.large_size) {
    const FairTopology::Ring ring = topology.ring(vertex);
    sums = sums_of(topology, ring.size(), [&](std::int32_t k) { return point(ring.corners[k]); });
    around.of_polygon = &sums;
  }
  double least = 1;
  const auto note = [&](const dvec3& normal, std::int32_t corner) {
    least = std::min(least, cosine_of(normal, face_normals[topology.corner_faces[corner]]));
  };
  const auto corners = topology.ring(vertex).corners;
  for (std::int32_t i = 0; i < topology.valence(vertex); ++i) {
    const std::int32_t corner = corners[i], after = topology.corner_ccw[corner];
    const std::int32_t next = around.beside(corner, 1), last = around.beside(corner, -1);
    const bool next_is_smooth = around.is_smooth(corner, next);
    const dvec3 own = around.in_polygon(vertex, i), face = around.in_face(corner);
    if (next_is_smooth) {
      const dvec3 edge = around.on_next(corner);
      note(glm::cross(around.on_previous(next) - face, around.in_face(next) - edge), corner);
    }
    if (!around.is_smooth(last, corner)) continue;
    const dvec3 edge = around.on_previous(corner);
    note(glm::cross(face - around.on_next(last), around.in_face(last) - edge), corner);
    if (next_is_smooth) note(glm::cross(face - own, edge - around.on_next(corner)), corner);
    const dvec3 side =
        glm::cross(around.on_next(after) - own, around.in_polygon(vertex, i + 1) - edge);
    note(side, corner);
    note(side, after);
  }
  return least;
}

}  // namespace planish
