#pragma once

#include <string>
#include <vector>

#include "mpi_job.h"
#include "planish/distributed/fit_distributed.h"
#include "terminal/exit_codes.h"

namespace planish::command {

/// The text of the report, as report.schema.json has it under `distributed`.
[[nodiscard]] std::string mpi_report(const std::vector<std::string>& arguments, const MpiJob& job,
                                     const DistributedFit& fit, ExitCode exit_code);

/// Some lines for people: the mesh, what was written, what phases took; without the last line end.
[[nodiscard]] std::string mpi_summary(const MpiJob& job, const DistributedFit& fit);

}  // namespace planish::command
