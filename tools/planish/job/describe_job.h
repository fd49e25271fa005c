#pragma once

#include "job/batch.h"

namespace planish::command {

/// What is written of all jobs together; empty paths: nothing.
struct BatchFiles {
  std::string report, page;
  std::uint64_t page_bytes = 0;  ///< limit of any page's size
};

/// A dry run: reads and checks every input as run_job() does, and says on stdout what would be
/// done: the files with their sizes, those that would be refused, peak memory and roughly the time.
/// Returns the exit code that the run would end with, as far as that can be told before the solve.
[[nodiscard]] ExitCode describe_jobs(const std::vector<PlannedJob>& jobs, const DeviceList& devices,
                                     const PathClaims& claims, const BatchFiles& files);

}  // namespace planish::command
