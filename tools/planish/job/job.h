#pragma once

#include <optional>
#include <string>
#include <vector>

#include "job/sampling.h"
#include "job/scene_move.h"
#include "options/given_setting.h"
#include "options/settings.h"
#include "output/output_plan.h"
#include "page/page.h"
#include "planish/backend/backend.h"
#include "planish/files/mesh_file.h"
#include "report/report.h"
#include "terminal/progress.h"

namespace planish::command {

/// One piece of work: a mesh in, its surface and reports out. `fit` makes one of its arguments,
/// `run` makes them of a scene file.
struct Job {
  std::string name;   ///< in tables, of progress
  std::string label;  ///< what messages begin with: a scene's job's name, else that of the input
  std::string input;  ///< path, or "-" for stdin
  std::optional<FileFormat> input_format;  ///< empty: by extension, else by content
  std::optional<Sampling> sampling;        ///< then the input is only what points are sampled from
  Settings settings;
  std::vector<SceneMove> moves;  ///< after the fit
  std::vector<OutputRequest> outputs;
  /// Names of the settings that flags gave, for a warning where one has no effect.
  std::vector<std::string> given_settings;
  /// Settings, "sample", "moves", "source" and "page" of a scene file as they stand there, those of
  /// the defaults first.
  std::vector<GivenSetting> given;
  std::string source;       ///< mesh that the surface is compared with; empty: the input
  std::string report;       ///< path, "-" for stdout, empty for none
  std::string page;         ///< the same
  bool overwrites = false;  ///< files that exist
};

/// What a job's steps share with the process around them.
struct JobContext {
  Console& console;
  JobProgress& progress;
  std::vector<std::string> arguments;  ///< argv, for the report
  PageOptions page;
  std::vector<PageJob>* page_jobs = nullptr;  ///< where set, what a page of all jobs needs

  [[nodiscard]] bool wants_page(const Job& job) const {
    return !job.page.empty() || page_jobs != nullptr;
  }
};

/// Reads, checks, fits, evaluates the levels, writes, reports. Files appear all together at the
/// end or, after an error, not at all. Not converging is a result with its own exit code.
/// Throws planish::Error.
JobReport run_job(const Job& job, const std::vector<PlannedOutput>& outputs, Backend& backend,
                  const JobContext& context);

/// The steps that run_job() will report, for JobProgress::plan().
[[nodiscard]] std::vector<PlannedStep> steps_of(const Job& job,
                                                const std::vector<PlannedOutput>& outputs);

}  // namespace planish::command
