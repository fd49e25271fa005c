#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/fair/bending_rows.h"
#include "planish/fair/fair_topology.h"
#include "planish/fair/plane_places.h"

namespace planish {

/// The vector by which a height of 1 moves the control points around each vertex: its normal, but 0
/// where they must stay, around vertices without a polygon or in a plane that is kept. Control
/// points of the tensor-product construction, a part `shares` of each vertex, stay as well near
/// curves: less bending between curves that cannot move is not more accuracy there.
[[nodiscard]] std::vector<glm::dvec3> polish_directions(const FairTopology& topology,
                                                        std::span<const glm::dvec3> normals,
                                                        std::span<const double> shares,
                                                        const PlanePlaces& planes = {});

/// Heights, one per place of the ring arrays, that lower the bending: `steps` steps of conjugate
/// gradients from 0 on the heights whose sum over each polygon is 0. The same bits for every thread
/// count. `bending` is used up. `halo`: where the mesh is a part.
[[nodiscard]] RawVector<float> polish_heights(const FairTopology& topology, BendingRows&& bending,
                                              std::int32_t steps, FairHalo* halo = nullptr);

/// Moves the control points in `offsets` by heights along the directions, those of each polygon
/// scaled so that none moves by more than 0.3 of its distance to the vertex: beyond that the
/// linearised bending is not to be trusted.
void apply_heights(const FairTopology& topology, std::span<const glm::dvec3> directions,
                   std::span<const float> heights, std::span<glm::dvec3> offsets);

}  // namespace planish
