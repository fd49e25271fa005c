#include "planish/fair/vertex_frame.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "planish/core/parallel.h"
#include "planish/mesh/area_vector.h"

namespace planish {

using glm::dvec2;
using glm::dvec3;

dvec2 VertexFrame::project(const dvec3& vector) const {
  return {glm::dot(vector, tangent1), glm::dot(vector, tangent2)};
}

namespace {

constexpr std::size_t kFrameGrain = 8192;
constexpr std::size_t kVertexGrain = 1024;
// Of the sum of the angles: a normal below this is what cancellation left.
constexpr double kCancelled = 1e-6;

// Cosine between a corner's own normal and its face's from which the corner's counts alone; and
// sine of its angle: straight corners have no normal of their own.
constexpr double kOwnNormalCosine = 0.5;
constexpr double kStraightSine = 0.05;

dvec3 normalised(const dvec3& vector) {
  const double length = glm::length(vector);
  return length > 0 ? vector / length : dvec3(0.0, 0.0, 1.0);
}

// How far a corner's own normal counts, 0 to 1; the rest is its face's.
double own_normal_part(const dvec3& a, const dvec3& b, const dvec3& turn, double length,
                       const dvec3& face_normal) {
  const double cosine = glm::dot(turn, face_normal) / length;
  const double sine = length / std::sqrt(glm::dot(a, a) * glm::dot(b, b));
  return std::clamp(cosine / kOwnNormalCosine, 0.0, 1.0) * std::min(sine / kStraightSine, 1.0);
}

// The angle from a to b counter-clockwise about a unit normal, 0 to a full turn.
double angle_about(const dvec3& a, const dvec3& b, const dvec3& turn, const dvec3& normal) {
  const double cosine = glm::dot(a, b) - glm::dot(a, normal) * glm::dot(b, normal);
  const double angle = std::atan2(glm::dot(turn, normal), cosine);
  return angle < 0 ? angle + 2 * std::numbers::pi : angle;
}

}  // namespace

std::vector<dvec3> unit_face_normals(const FairTopology& topology, std::span<const dvec3> given) {
  std::vector<dvec3> normals(static_cast<std::size_t>(topology.face_count));
  parallel_each(normals.size(), kFrameGrain, [&](std::int32_t face) {
    normals[face] = normalised(area_vector(given, topology.face(face)));
  });
  return normals;
}

dvec3 angle_weighted_normal(const FairTopology& topology, std::span<const dvec3> given,
                            std::span<const dvec3> face_normals, std::int32_t vertex,
                            const FairTopology::Ring& ring) {
  dvec3 sum(0.0);
  double angles = 0;
  for (std::int32_t i = 0; i < ring.size(); ++i) {
    const dvec3 a = given[ring.next[i]] - given[vertex];
    const dvec3 b = given[ring.previous[i]] - given[vertex];
    const dvec3 turn = glm::cross(a, b);
    const double length = glm::length(turn);
    const std::int32_t face = topology.corner_faces[ring.corners[i]];
    double own_part = 0;
    if (length > 0) {
      own_part = own_normal_part(a, b, turn, length, face_normals[face]);
      const double own_angle = own_part * std::atan2(length, glm::dot(a, b));
      angles += own_angle;
      sum += own_angle / length * turn;
    } else if (topology.face_size(face) == 3) {
      continue;  // without area: its face has no normal either
    }
    if (own_part == 1) continue;
    const double face_angle = (1 - own_part) * angle_about(a, b, turn, face_normals[face]);
    angles += face_angle;
    sum += face_angle * face_normals[face];
  }
  const double length = glm::length(sum);
  if (length > kCancelled * angles) return sum / length;
  sum = dvec3(0.0);
  for (const std::int32_t corner : ring.corners) sum += face_normals[topology.corner_faces[corner]];
  return normalised(sum);
}

std::vector<dvec3> vertex_normals(const FairTopology& topology, std::span<const dvec3> given,
                                  std::span<const dvec3> face_normals, const PlanePlaces& planes) {
  std::vector<dvec3> normals(given.size());
  parallel_each(normals.size(), kVertexGrain, [&](std::int32_t v) {
    const std::int32_t plane = planes.of(v);
    normals[v] = plane >= 0
                     ? face_normals[plane]
                     : angle_weighted_normal(topology, given, face_normals, v, topology.ring(v));
  });
  return normals;
}

// Source: Duff et al., "Building an orthonormal basis, revisited", 2017.
VertexFrame frame_of(const dvec3& n) {
  const double sign = std::copysign(1.0, n.z);
  const double a = -1.0 / (sign + n.z);
  const double b = n.x * n.y * a;
  return {{1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, n};
}

}  // namespace planish
