#pragma once

#include <span>

#include "planish/job/job.h"
#include "planish/job/job_input.h"
#include "planish/pipeline/fit_mesh.h"

namespace planish {

/// fit_prepared() into `made` and the moves of its vertices, noted in the report: figures, times,
/// and exit code 5 with a warning where the solve does not converge. Throws as that.
void fit_input(JobInput& made, ReadyFit&& ready, Backend& backend, std::span<const SceneMove> moves,
               JobReport& report, const JobContext& context);

/// The same of a control cage, after it, into JobInput::cage; nothing where the surface has that
/// cage itself.
void fit_cage(JobInput& made, ReadyFit&& ready, Backend& backend, std::span<const SceneMove> moves,
              JobReport& report, const JobContext& context);

}  // namespace planish
