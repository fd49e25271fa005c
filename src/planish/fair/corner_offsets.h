#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/fair/fair_topology.h"

namespace planish {

/// One Doo-Sabin step of `points` (one per vertex): the control point of every corner, relative to
/// the given point of its vertex. `offsets`: one per corner.
void corner_offsets(const FairTopology& topology, std::span<const glm::dvec3> given,
                    std::span<const glm::dvec3> points, std::span<glm::dvec3> offsets);

/// The same of the given points themselves, for single corners.
class GivenStep {
 public:
  GivenStep(const FairTopology& topology, std::span<const glm::dvec3> given);
  [[nodiscard]] glm::dvec3 offset(std::int32_t corner) const;

 private:
  const FairTopology& topology_;
  std::span<const glm::dvec3> given_;
  std::vector<std::vector<glm::dvec3>> of_large_;  // by FairTopology::large_faces
};

}  // namespace planish
