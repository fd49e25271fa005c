#pragma once

#include "input.h"
#include "job.h"
#include "planish/core/callbacks.h"
#include "planish/pipeline/fit.h"

namespace planish::command {

/// fit() as the job's settings say, noted in the report: figures, times, warnings, and exit code 5
/// where the solve does not converge. Errors name the input's file.
[[nodiscard]] Fit fit_input(const Input& input, Backend& backend, JobReport& report,
                            const JobContext& context);

}  // namespace planish::command
