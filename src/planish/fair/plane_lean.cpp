#include "planish/fair/plane_lean.h"

#include <cmath>
#include <glm/geometric.hpp>

namespace planish {

using glm::dvec2;
using glm::dvec3;

dvec2 ring_direction(const FairTopology& topology, std::span<const dvec3> given,
                     std::int32_t vertex, const VertexFrame& frame) {
  const auto next = topology.ring(vertex).next;
  const auto circle = topology.unit_circle.of(topology.valence(vertex));
  dvec2 sum(0.0);
  for (std::size_t i = 0; i < next.size(); ++i) {
    const dvec2 edge = frame.project(given[next[i]] - given[vertex]);
    const double length = glm::length(edge);
    if (!(length > 0)) continue;
    // Turned back by the place's angle.
    sum += dvec2(edge.x * circle[i].x + edge.y * circle[i].y,
                 edge.y * circle[i].x - edge.x * circle[i].y) /
           length;
  }
  const double length = glm::length(sum);
  return length > 0 ? sum / length : dvec2(1.0, 0.0);
}

RingAxes ring_axes(const FairTopology& topology, std::span<const dvec3> given, std::int32_t vertex,
                   const dvec3& normal) {
  const VertexFrame frame = frame_of(normal);
  const dvec2 direction = ring_direction(topology, given, vertex, frame);
  return {direction.x * frame.tangent1 + direction.y * frame.tangent2,
          direction.x * frame.tangent2 - direction.y * frame.tangent1};
}

glm::vec2 lean_towards(const FairTopology& topology, std::span<const dvec3> given,
                       std::int32_t vertex, const dvec3& normal, const dvec3& target) {
  if (target == normal) return glm::vec2(0.0F);
  const RingAxes axes = ring_axes(topology, given, vertex, normal);
  const dvec2 flat(glm::dot(target, axes.along), glm::dot(target, axes.left));
  const double sine = glm::length(flat);
  if (!(sine > 0)) return glm::vec2(0.0F);
  return glm::vec2(std::atan2(sine, glm::dot(target, normal)) / sine * flat);
}

dvec3 leaning_normal(const FairTopology& topology, std::span<const dvec3> given,
                     std::int32_t vertex, const dvec3& normal, const glm::vec2& lean) {
  const dvec2 wanted(lean);
  const double angle = glm::length(wanted);
  if (!(angle > 0)) return normal;
  const RingAxes axes = ring_axes(topology, given, vertex, normal);
  return std::cos(angle) * normal +
         std::sin(angle) / angle * (wanted.x * axes.along + wanted.y * axes.left);
}

}  // namespace planish
