#pragma once

#include "job/job.h"
#include "job/job_input.h"
#include "planish/pipeline/fit.h"

namespace planish::command {

/// fit() as the job's settings say, noted in the report: figures, times, warnings, and exit code 5
/// where the solve does not converge. Errors name the input's file.
[[nodiscard]] Fit fit_input(JobInput& made, Backend& backend, JobReport& report,
                            const JobContext& context);

}  // namespace planish::command
