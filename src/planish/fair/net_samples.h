#pragma once

#include <atomic>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/fair/fair_topology.h"

namespace planish {

/// Limit normals of a net of level 1 at the places where they depend on the fewest control points;
/// of any length, zero where there is none. `offsets`: the state relative to the given points.
struct NetSamples {
  /// All that a step asks of a polygon besides the own point: its mean and first Fourier pair.
  struct PolygonSums {
    glm::dvec3 mean, even, odd;
  };

  const FairTopology& topology;
  std::span<const glm::dvec3> given, offsets;
  std::vector<PolygonSums> of_large_faces{};  ///< by FairTopology::large_faces

  /// Before least_cosine_around() where there are large faces, whenever offsets have changed.
  void sum_large_faces();

  [[nodiscard]] glm::dvec3 point(std::int32_t corner) const {
    return given[topology.corner_vertices[corner]] + offsets[corner];
  }
  [[nodiscard]] glm::dvec3 at_edge(const FairTopology::Edge& edge) const;
  [[nodiscard]] glm::dvec3 at_face(std::int32_t face) const;
  /// Around the vertex must be a polygon.
  [[nodiscard]] glm::dvec3 at_vertex(std::int32_t vertex) const;
  /// The least cosine between the normals of the faces around a vertex with a polygon and the
  /// limit normals at the places that the next step adds between it and them: at its control
  /// points, on the sides of its polygon, and on those of the faces' polygons that begin or end at
  /// it. 1 where there are none, beside sharp edges.
  [[nodiscard]] double least_cosine_around(std::int32_t vertex,
                                           std::span<const glm::dvec3> face_normals) const;
};

/// Sets a vertex's flag, from several threads: whoever sets, sets the same.
inline void flag(std::span<std::uint8_t> flags, std::int32_t vertex) {
  std::atomic_ref(flags[vertex]).store(1, std::memory_order_relaxed);
}

/// Between a normal of any length and a unit vector; -1 where the normal is zero.
[[nodiscard]] double cosine_of(const glm::dvec3& normal, const glm::dvec3& reference);

}  // namespace planish
