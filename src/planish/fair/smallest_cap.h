#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

#include "planish/fair/fair_topology.h"

namespace planish {

/// The direction that is nearest to all normals of the faces around a vertex, and the least cosine
/// with them: at 0 no plane through the vertex sees all of them from outside.
struct NormalCap {
  glm::dvec3 normal;  ///< unit
  double cosine;
};

/// The vertex's own normal, with the cosine 0, where there is none; see best_view().
[[nodiscard]] NormalCap smallest_cap(const FairTopology& topology,
                                     std::span<const glm::dvec3> face_normals, std::int32_t vertex,
                                     const glm::dvec3& normal);

/// The vertex's normal where all faces around it are seen from it well enough, at a fifth of the
/// cap's cosine; else turned towards the cap's as far as that takes. Continuous.
[[nodiscard]] glm::dvec3 tilted_normal(const FairTopology& topology,
                                       std::span<const glm::dvec3> face_normals,
                                       std::int32_t vertex, const glm::dvec3& normal);

/// The least cosine between a unit direction and the normals of the faces around a vertex.
[[nodiscard]] double least_face_cosine(const FairTopology& topology,
                                       std::span<const glm::dvec3> face_normals,
                                       std::int32_t vertex, const glm::dvec3& direction);

}  // namespace planish
