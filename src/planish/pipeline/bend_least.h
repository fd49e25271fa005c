#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <span>

#include "planish/backend/backend.h"
#include "planish/doosabin/sharp_features.h"
#include "planish/fair/fair_halo.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/pipeline/fit.h"

namespace planish {

/// Moves the points that a surface is to pass through, one per vertex in unit coordinates, to where
/// the mesh bends least, as far as options.within lets them; none where that is 0. Nothing is said
/// of the surface: for ranks, which do not measure it. Each calls it for its part: the same bits
/// but for sums over blocks. Throws Error{InvalidArgument}.
[[nodiscard]] std::optional<WithinFit> bend_least(
    const MeshTopology& topology, const SharpFeatures& features, const Placement& placement,
    const FitOptions& options, std::span<glm::dvec3> points, FairHalo* halo = nullptr);

/// Makes of the surface through the given vertices one that leaves them by no more than
/// options.within and bends less, folded no more, as a report measures both; it stays where there
/// is none. Of those through the points where the mesh bends least within the bound, half of it,
/// and so on, the one that bends least. Warnings are those of the surfaces that are tried and
/// taken. Throws as fit().
void leave_vertices(const PolygonMesh& mesh, Backend& backend, const FitOptions& options,
                    Fit& result);

}  // namespace planish
