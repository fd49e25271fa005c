#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/fair/fair_halo.h"
#include "planish/fair/fair_topology.h"

namespace planish {

/// How far the limit point of `points` at a vertex is from its given point; 0 at corners.
/// `offsets`: control points of `points` (corner_offsets).
[[nodiscard]] glm::dvec3 limit_error(const FairTopology& topology,
                                     std::span<const glm::dvec3> given,
                                     std::span<const glm::dvec3> points,
                                     std::span<const glm::dvec3> offsets, std::int32_t vertex);

/// Three plain steps of progressive interpolation, P += share (given - B P) from P = given: keeps
/// the accuracy of tensor products where the mesh is a regular grid. `shares`: one per vertex; 0 at
/// corners. Returns P and leaves its control points in `offsets`, which must hold those of
/// `given` on entry (corner_offsets). `halo`: where the mesh is a part.
[[nodiscard]] std::vector<glm::dvec3> masked_iteration(const FairTopology& topology,
                                                       std::span<const glm::dvec3> given,
                                                       std::span<const double> shares,
                                                       std::span<glm::dvec3> offsets,
                                                       FairHalo* halo = nullptr);

}  // namespace planish
