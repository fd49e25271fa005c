#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <unordered_map>

#include "planish/fair/fair_topology.h"
#include "planish/fair/planar_ring.h"

namespace planish {

/// How far the limit points of the given points miss them: of hubs, whose rings are long and which
/// all their neighbours ask, made once.
class GivenErrors {
 public:
  /// `corner_offsets`: of one step of the given points. All must outlive it.
  GivenErrors(const FairTopology& topology, std::span<const glm::dvec3> given,
              std::span<const glm::dvec3> corner_offsets);

  [[nodiscard]] glm::dvec3 of(std::int32_t vertex) const;

  const FairTopology& topology;
  std::span<const glm::dvec3> given, corner_offsets;

 private:
  [[nodiscard]] bool is_hub(std::int32_t vertex) const;
  [[nodiscard]] glm::dvec3 made(std::int32_t vertex) const;

  std::unordered_map<std::int32_t, glm::dvec3> of_hubs_;
};

/// How far a vertex takes part in the tensor-product construction, 0 to 1: only among quads, and
/// the less the farther its control points are out of balance, be it by themselves or against those
/// of its neighbours. Continuous in the given points. `normal`: the vertex's, unit; `scratch` is
/// reused from vertex to vertex.
[[nodiscard]] double tensor_share(const GivenErrors& errors, const glm::dvec3& normal,
                                  std::int32_t vertex, PlanarRing& scratch);

}  // namespace planish
