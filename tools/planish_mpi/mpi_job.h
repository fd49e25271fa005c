#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "planish/distributed/fit_distributed.h"
#include "planish/files/formats.h"
#include "planish/job/job.h"

namespace planish::command {

/// What planish-mpi has besides the options of planish.
struct MpiSettings {
  std::optional<std::int64_t> block_vertices;
  bool force = false, resume = false, is_scene = false;
  double watchdog_seconds = 600;
};

/// One mesh in, what is made of it out.
struct MpiJob {
  std::string name;  ///< of a scene's job
  std::string input;
  std::optional<FileFormat> input_format;
  Settings settings;
  DistributedOptions options;
  std::string tiles, cage;
  std::string report;                  ///< "-": stdout
  std::vector<OutputRequest> outputs;  ///< tiles and cage with where they were asked for
};

/// A job of planish as ranks do it. Throws Error{InvalidArgument} naming the place for what they
/// have not: settings, outputs of other kinds, several of one kind.
[[nodiscard]] MpiJob mpi_job_of(const Job& job, const MpiSettings& own);

/// Looks whether all files of the jobs can be written, as planish does. Looks at the disk.
/// Throws as PathClaims.
void claim_files(const std::vector<MpiJob>& jobs, const std::string& scene, const MpiSettings& own);

/// The phases of a job and what they take beside each other.
[[nodiscard]] std::vector<PlannedStep> steps_of(const MpiJob& job);

/// Makes the folders of a job's outputs that are missing. Throws Error{UnwritableOutput}.
void make_folders(const MpiJob& job);

}  // namespace planish::command
