#pragma once

#include <cstddef>
#include <vector>

#include "planish/job/job.h"
#include "planish/job/job_input.h"
#include "planish/job/staged_files.h"

namespace planish {

/// A fitted job on its way to its files.
struct FittedJob {
  const Job& job;
  const std::vector<PlannedOutput>& outputs;
  Backend& backend;
  const JobContext& context;
  const JobInput& made;
  JobReport& report;
  StagedFiles& staged;
};

/// Writes cages, evaluates every level once, whatever the number of files that show it, and
/// measures the surface; all noted in the report. Shows it to the page. Returns what is meant for
/// stdout.
[[nodiscard]] std::vector<std::byte> write_outputs(const FittedJob& work);

}  // namespace planish
