#pragma once

#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/fair/fair_topology.h"

namespace planish {

/// How far a vertex takes part in the tensor-product construction, 0 to 1, by its imbalance: a
/// blend, so that a deforming mesh does not jump.
[[nodiscard]] double tensor_share(double rho);

/// Three plain steps of progressive interpolation, P += share (given - B P) from P = given: keeps
/// the accuracy of tensor products where the mesh is a regular grid. `shares`: one per vertex; 0 at
/// corners. Returns P and leaves its control points in `offsets`, which must hold those of
/// `given` on entry (corner_offsets).
[[nodiscard]] std::vector<glm::dvec3> masked_iteration(const FairTopology& topology,
                                                       std::span<const glm::dvec3> given,
                                                       std::span<const double> shares,
                                                       std::span<glm::dvec3> offsets);

}  // namespace planish
