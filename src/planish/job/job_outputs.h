#pragma once

#include <cstddef>
#include <vector>

#include "planish/job/job.h"
#include "planish/job/job_input.h"
#include "planish/job/job_surface.h"
#include "planish/job/staged_files.h"

namespace planish {

/// A fitted job on its way to its files.
struct FittedJob {
  const Job& job;
  const std::vector<PlannedOutput>& outputs;
  Backend& backend;
  const JobContext& context;
  const JobInput& made;
  const FittedMesh& fitted;  ///< what `made` comes to
  JobReport& report;
  StagedFiles& staged;
};

/// Shows a mesh of the job to its page, where there is one.
void show_mesh(const FittedJob& work, std::size_t mesh, JobSurface& all);

/// Writes cages, evaluates every level once, whatever the number of files that show it, and
/// measures the surface; all noted in the report. Shows it to the page. Returns what is meant for
/// stdout.
[[nodiscard]] std::vector<std::byte> write_outputs(const FittedJob& work);

/// The files of a job whose mesh is fitted already. Throws planish::Error.
[[nodiscard]] std::vector<WrittenOutput> write_fitted(const FittedMesh& fitted, Job job,
                                                      PathClaims& claims, Backend& backend,
                                                      const JobWatch& watch);

}  // namespace planish
