#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "commands.h"
#include "planish/distributed/fit_distributed.h"
#include "planish/files/formats.h"
#include "planish/job/job.h"
#include "planish/job/job_settings.h"
#include "terminal.h"

namespace planish::command {

/// An option of `planish fit`, `planish run` or a scene file: by its name there, with '_' for '-'.
enum class MpiOption { Taken, SomeWords, Refused };

/// What planish-mpi makes of it. One that it has not heard of is refused.
[[nodiscard]] MpiOption mpi_option(std::string_view name);

/// The words of it that are taken, "chebyshev|plain"; empty where that is all or nothing.
[[nodiscard]] std::string words_taken(std::string_view name);

/// Throws Error{InvalidArgument}, `where: value is not available in planish-mpi: remedy`, for the
/// first that is refused. Of settings that were given twice the later one counts. `settings` is
/// what all of them came to.
void require_available(std::span<const GivenSetting> given, const FitSettings& settings);

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

/// The text of the report, as report.schema.json has it under `distributed`.
[[nodiscard]] std::string mpi_report(const std::vector<std::string>& arguments, const MpiJob& job,
                                     const DistributedFit& fit, ExitCode exit_code);

/// Some lines for people: the mesh, what was written, what phases took; without the last line end.
[[nodiscard]] std::string mpi_summary(const MpiJob& job, const DistributedFit& fit);

/// What the command line asks for.
struct MpiRequest {
  std::string text;                ///< to be printed instead of any work: help or version
  std::vector<Job> jobs;           ///< of `fit` its one
  std::string scene;               ///< of `run`
  std::vector<std::string> names;  ///< jobs of it; all where none is named
  MpiSettings own;
  MessageFlags messages;
};

/// Reads the command line, whose flags are those of `planish fit` and `planish run` with a few
/// more. Throws Error{InvalidArgument} naming the flag for what is wrong, and for what ranks have
/// not.
[[nodiscard]] MpiRequest parse_mpi_flags(const std::vector<std::string>& arguments);

}  // namespace planish::command
