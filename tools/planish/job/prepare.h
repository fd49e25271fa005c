#pragma once

#include "options/settings.h"
#include "planish/fair/interpolation_method.h"
#include "planish/mesh/repair.h"

namespace planish::command {

/// The mesh that is fitted: repaired unless the choice is none, with creases detected where the
/// choice names an angle, and for fair surfaces, which fold beside corners that turn inward, with
/// concave faces cut where repair may. A mesh that remains unusable comes back as it is, for
/// require_usable() to refuse. Throws what repair() throws.
[[nodiscard]] RepairedMesh prepare(const PolygonMesh& mesh, RepairChoice repair,
                                   const CreaseChoice& creases, InterpolationMethod method);

/// The same for a job, whose scene file may tag further edges and vertices of the input. Throws
/// Error{UnusableMesh} for a tag that names no vertex.
[[nodiscard]] RepairedMesh prepare(const PolygonMesh& mesh, const Settings& settings,
                                   InterpolationMethod method);

}  // namespace planish::command
