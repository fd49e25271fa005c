#pragma once

#include "job/job_input.h"
#include "planish/pipeline/fit.h"
#include "planish/surface/surface_mesh.h"
#include "report/report.h"

namespace planish::command {

/// Distances of points are measured on a tessellation: from this level on it is as good as the
/// surface.
inline constexpr int kPointDistanceLevel = 2;

/// Notes in the report how good a level of the surface is, unless a level before it has: against
/// the source where there is one, else the input; the distances of a cloud's points from
/// kPointDistanceLevel on. Nothing of it can be seen at level 0. Warns "folded-area".
void measure_surface(const JobInput& made, const Fit& fitted, const SurfaceMesh& surface,
                     JobReport& report, Console& console);

}  // namespace planish::command
