#include "planish/fair/smallest_cap.h"

#include <glm/geometric.hpp>
#include <iterator>

#include "planish/core/work.h"
#include "planish/fair/best_view.h"

namespace planish {

using glm::dvec3;

namespace {

// Smaller rings cost less than the count of them.
constexpr std::size_t kCounted = 32;

auto worst_face(const FairTopology& topology, std::span<const dvec3> face_normals,
                std::int32_t vertex) {
  return [=, &topology, corners = topology.ring(vertex).corners](const dvec3& direction) {
    if (corners.size() >= kCounted) count_work(Work::Points, std::ssize(corners));
    return least_seen<dvec3>(corners, direction, [&](std::int32_t corner) {
      return face_normals[topology.corner_faces[corner]];
    });
  };
}

dvec3 normalised_or(const dvec3& vector, const dvec3& otherwise) {
  const double length = glm::length(vector);
  return length > 0 ? vector / length : otherwise;
}

}  // namespace

double least_face_cosine(const FairTopology& topology, std::span<const dvec3> face_normals,
                         std::int32_t vertex, const dvec3& direction) {
  return worst_face(topology, face_normals, vertex)(direction).cosine;
}

NormalCap smallest_cap(const FairTopology& topology, std::span<const dvec3> face_normals,
                       std::int32_t vertex, const dvec3& normal) {
  const auto best = best_view(normal, worst_face(topology, face_normals, vertex));
  return {best.vector, best.cosine};
}

dvec3 tilted_normal(const FairTopology& topology, std::span<const dvec3> face_normals,
                    std::int32_t vertex, const dvec3& normal) {
  return turned_to_see(normal, worst_face(topology, face_normals, vertex), normalised_or);
}

}  // namespace planish
