#include "planish/fair/crease_handle.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace planish {

using glm::dvec3;

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

}  // namespace planish
