#pragma once

#include <cstddef>
#include <vector>

#include "job/job.h"
#include "job/job_input.h"
#include "output/staged_files.h"

namespace planish::command {

/// A fitted job on its way to its files.
struct FittedJob {
  const Job& job;
  const std::vector<PlannedOutput>& outputs;
  Backend& backend;
  const JobContext& context;
  const JobInput& made;
  JobReport& report;
  StagedFiles& staged;
  PageJob& page;  ///< whose scene is made where a page is wanted
};

/// Writes cages, evaluates every level once, whatever the number of files that show it, and
/// measures the surface; all noted in the report. Makes the page's scene. Returns what is meant for
/// stdout.
[[nodiscard]] std::vector<std::byte> write_outputs(const FittedJob& work);

}  // namespace planish::command
