#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <span>

#include "planish/doosabin/sharp_features.h"
#include "planish/fair/fair_halo.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/pipeline/fit.h"

namespace planish {

/// Moves the points that a surface is to pass through, one per vertex in unit coordinates, to where
/// the mesh bends least, as far as options.within lets them; none where that is 0. Over ranks each
/// calls it for its part: the same bits but for sums over blocks. Throws Error{InvalidArgument}.
[[nodiscard]] std::optional<WithinFit> bend_least(
    const MeshTopology& topology, const SharpFeatures& features, const Placement& placement,
    const FitOptions& options, std::span<glm::dvec3> points, FairHalo* halo = nullptr);

}  // namespace planish
