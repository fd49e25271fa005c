// Names: A the 2 x 2 matrix of the ellipse, t_i the direction of the unit circle's side across the
// edge e_i, m the direction in a face beside it that is at right angles to e_i, inwards. The limit
// normal at the edge of small polygons is along e_i x A t_i, and on the face's side where
// m . A t_i > 0: linear in A. So A is the direction of R^4 that sees all of m (x) t_i best, which
// fair/best_view.h finds.
#include "planish/fair/hub_ellipse.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <numbers>
#include <vector>

#include "planish/core/unit_vector.h"
#include "planish/fair/best_view.h"
#include "planish/fair/plane_lean.h"
#include "planish/fair/vertex_frame.h"

namespace planish {

using glm::dvec2;
using glm::dvec3;
using glm::dvec4;

namespace {

dvec2 times(const dvec4& ellipse, const dvec2& point) {
  return {ellipse.x * point.x + ellipse.y * point.y, ellipse.z * point.x + ellipse.w * point.y};
}

// What each side of the ellipse has to do with the two faces that it leads to, along `axes`.
std::vector<dvec4> side_conditions(const FairTopology& topology, std::span<const dvec3> given,
                                   std::span<const dvec3> face_normals, std::int32_t vertex,
                                   const RingAxes& axes) {
  const FairTopology::Ring ring = topology.ring(vertex);
  const std::int32_t n = ring.size();
  std::vector<dvec4> conditions;
  for (std::int32_t i = 0; i < n; ++i) {
    const dvec3 edge = unit_or_zero(given[ring.next[i]] - given[vertex]);
    const double angle = std::numbers::pi * (2 * i - 1) / n;
    const dvec2 side(-std::sin(angle), std::cos(angle));
    for (const std::int32_t place : {i, (i + n - 1) % n}) {
      const std::int32_t face = topology.corner_faces[ring.corners[place]];
      const dvec3 inward = glm::cross(face_normals[face], edge);
      const dvec2 flat(glm::dot(inward, axes.along), glm::dot(inward, axes.left));
      conditions.emplace_back(flat.x * side.x, flat.x * side.y, flat.y * side.x, flat.y * side.y);
    }
  }
  return conditions;
}

}  // namespace

glm::vec4 hub_ellipse(const FairTopology& topology, std::span<const dvec3> given,
                      std::span<const dvec3> face_normals, std::int32_t vertex,
                      const dvec3& plane) {
  const std::vector<dvec4> conditions = side_conditions(topology, given, face_normals, vertex,
                                                        ring_axes(topology, given, vertex, plane));
  const auto worst_of = [&](const dvec4& ellipse) {
    return least_seen<dvec4>(conditions, ellipse, [](const dvec4& condition) { return condition; });
  };
  const auto [best, most] = best_view(dvec4(1.0, 0.0, 0.0, 1.0) / std::numbers::sqrt2, worst_of);
  if (!(most > 0) || !(best.x * best.w > best.y * best.z)) return glm::vec4(0.0F);
  double farthest = 0;
  for (const dvec2& point : topology.unit_circle.of(topology.valence(vertex)))
    farthest = std::max(farthest, glm::length(times(best, point)));
  return glm::vec4(best / farthest);
}

namespace {

// And those of their faces: what folds at an edge, both of its ends' polygons make.
std::vector<std::uint8_t> with_neighbours(const FairTopology& topology,
                                          std::span<const std::uint8_t> flagged) {
  std::vector<std::uint8_t> wanted(flagged.begin(), flagged.end());
  for (std::int32_t face = 0; face < topology.face_count; ++face) {
    const auto vertices = topology.face(face);
    if (std::ranges::none_of(vertices, [&](std::int32_t v) { return flagged[v] != 0; })) continue;
    for (const std::int32_t v : vertices) wanted[v] = 1;
  }
  return wanted;
}

}  // namespace

std::vector<std::uint8_t> choose_ellipses(const FairTopology& topology,
                                          std::span<const dvec3> given,
                                          std::span<const std::uint8_t> flagged,
                                          FairDecisions& decisions) {
  const std::vector<dvec3> face_normals = unit_face_normals(topology, given);
  const std::vector<dvec3> normals =
      vertex_normals(topology, given, face_normals, plane_places(topology, decisions.planes));
  decisions.ellipses.resize(given.size(), glm::vec4(0.0F));
  const std::vector<std::uint8_t> wanted = with_neighbours(topology, flagged);
  std::vector<std::uint8_t> chosen(given.size(), 0);
  for (std::size_t v = 0; v < wanted.size(); ++v) {
    const auto vertex = static_cast<std::int32_t>(v);
    if (wanted[v] == 0 || decisions.cures[v] == 0 || !topology.has_polygon(vertex) ||
        is_ellipse(decisions.ellipses[v]) || !is_chosen(decisions.leans[v]))
      continue;
    const dvec3 plane = leaning_normal(topology, given, vertex, normals[v], decisions.leans[v]);
    decisions.ellipses[v] = hub_ellipse(topology, given, face_normals, vertex, plane);
    chosen[v] = is_ellipse(decisions.ellipses[v]);
  }
  return chosen;
}

void build_hub_ellipse(const FairTopology& topology, std::span<const dvec3> given,
                       std::int32_t vertex, const dvec3& plane, const glm::vec4& ellipse,
                       double size, std::span<dvec3> offsets) {
  const RingAxes axes = ring_axes(topology, given, vertex, plane);
  const auto corners = topology.ring(vertex).corners;
  const auto circle = topology.unit_circle.of(topology.valence(vertex));
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const dvec2 point = size * times(dvec4(ellipse), circle[i]);
    offsets[corners[i]] = point.x * axes.along + point.y * axes.left;
  }
}

}  // namespace planish
