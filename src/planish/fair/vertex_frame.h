#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/fair/fair_topology.h"
#include "planish/fair/plane_places.h"

namespace planish {

/// Right-handed and orthonormal, `normal` outward.
struct VertexFrame {
  glm::dvec3 tangent1, tangent2, normal;

  [[nodiscard]] glm::dvec2 project(const glm::dvec3& vector) const;
};

/// Unit Newell normals; +Z where a face has no area.
[[nodiscard]] std::vector<glm::dvec3> unit_face_normals(const FairTopology& topology,
                                                        std::span<const glm::dvec3> given);

/// Unit normal at a vertex: the normals of the ring's corners, weighted by their angles. A corner
/// that turns inward or lies athwart its face takes the face's normal, of `face_normals`
/// (unit_face_normals()), and its angle about that, up to a full turn. Where they cancel, the sum
/// of the faces' normals.
[[nodiscard]] glm::dvec3 angle_weighted_normal(const FairTopology& topology,
                                               std::span<const glm::dvec3> given,
                                               std::span<const glm::dvec3> face_normals,
                                               std::int32_t vertex, const FairTopology::Ring& ring);

/// Those of all vertices, each of its whole ring or of the plane there.
[[nodiscard]] std::vector<glm::dvec3> vertex_normals(const FairTopology& topology,
                                                     std::span<const glm::dvec3> given,
                                                     std::span<const glm::dvec3> face_normals,
                                                     const PlanePlaces& planes = {});

/// `normal` of unit length.
[[nodiscard]] VertexFrame frame_of(const glm::dvec3& normal);

}  // namespace planish
