#pragma once

#include <glm/vec3.hpp>
#include <span>

#include "planish/core/raw_vector.h"
#include "planish/doosabin/face_rule.h"
#include "planish/patches/patch_mesh.h"

namespace planish {

/// The state of level 1 of a cage's surface, see Subdivision: one Doo-Sabin step, on all threads.
/// `points` are the cage's, one per vertex of the mesh; the state is in their coordinates.
[[nodiscard]] RawVector<glm::dvec3> first_step(const PatchMesh& mesh, Weights weights,
                                               std::span<const glm::dvec3> points);

/// The same, to the bit, of the points that some faces have: their corners and the ends of their
/// sharp edges. `state` holds all of it; sums of large rings stay, see update_sums_at().
void update_first_step(const PatchMesh& mesh, const FaceWeights& weights,
                       std::span<const glm::dvec3> points, std::span<const std::int32_t> faces,
                       std::span<glm::dvec3> state);

}  // namespace planish
