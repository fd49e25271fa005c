#include "planish/fair/smallest_cap.h"

#include <glm/geometric.hpp>

namespace planish {

using glm::dvec3;

namespace {

constexpr int kCapSteps = 60;
constexpr int kTiltSteps = 8;
// Of the cap's cosine: what a normal must have with every face to be left as it is.
constexpr double kSeenShare = 0.2;

struct WorstFace {
  double cosine;
  dvec3 normal;
};

WorstFace worst_face(const FairTopology& topology, std::span<const dvec3> face_normals,
                     std::int32_t vertex, const dvec3& direction) {
  WorstFace worst{2, dvec3(0.0)};
  for (std::int32_t i = topology.ring_offsets[vertex]; i < topology.ring_offsets[vertex + 1]; ++i) {
    const dvec3& normal = face_normals[topology.corner_faces[topology.ring_corners[i]]];
    const double cosine = glm::dot(direction, normal);
    if (cosine < worst.cosine) worst = {cosine, normal};
  }
  return worst;
}

dvec3 normalised_or(const dvec3& vector, const dvec3& otherwise) {
  const double length = glm::length(vector);
  return length > 0 ? vector / length : otherwise;
}

}  // namespace

double least_face_cosine(const FairTopology& topology, std::span<const dvec3> face_normals,
                         std::int32_t vertex, const dvec3& direction) {
  return worst_face(topology, face_normals, vertex, direction).cosine;
}

NormalCap smallest_cap(const FairTopology& topology, std::span<const dvec3> face_normals,
                       std::int32_t vertex, const dvec3& normal) {
  NormalCap best{normal, -2};
  dvec3 direction = normal;
  for (int step = 0; step < kCapSteps; ++step) {
    const WorstFace worst = worst_face(topology, face_normals, vertex, direction);
    if (worst.cosine > best.cosine) best = {direction, worst.cosine};
    direction = normalised_or(direction + (worst.normal - direction) / (2.0 + step), direction);
  }
  return best;
}

dvec3 tilted_normal(const FairTopology& topology, std::span<const dvec3> face_normals,
                    std::int32_t vertex, const dvec3& normal) {
  const NormalCap cap = smallest_cap(topology, face_normals, vertex, normal);
  const double wanted = kSeenShare * cap.cosine;
  const auto is_seen = [&](const dvec3& direction) {
    return least_face_cosine(topology, face_normals, vertex, direction) >= wanted;
  };
  if (cap.cosine <= 0 || is_seen(normal)) return normal;
  const auto between = [&](double share) {
    return normalised_or((1 - share) * normal + share * cap.normal, cap.normal);
  };
  double least = 0, enough = 1;
  for (int step = 0; step < kTiltSteps; ++step) {
    const double middle = (least + enough) / 2;
    (is_seen(between(middle)) ? enough : least) = middle;
  }
  return between(enough);
}

}  // namespace planish
