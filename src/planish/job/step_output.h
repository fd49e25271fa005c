#pragma once

#include <filesystem>

#include "planish/job/report.h"
#include "planish/job/surface_output.h"
#include "planish/limit/limit_surface.h"
#include "planish/pipeline/write_fitted_step.h"

namespace planish {

/// Writes the surface of a fitted mesh as STEP, as fit_file() does, and measures what was written.
/// `limit`: of Doo-Sabin, where it is at hand; else null.
[[nodiscard]] WrittenOutput write_step_output(const PlannedOutput& planned,
                                              const std::filesystem::path& target,
                                              const LimitSurface* limit, const FittedMesh& fitted,
                                              const StepSettings& settings,
                                              const SurfaceOutputOptions& options);

}  // namespace planish
