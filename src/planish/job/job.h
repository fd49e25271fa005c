#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "planish/backend/backend.h"
#include "planish/core/callbacks.h"
#include "planish/files/mesh_file.h"
#include "planish/job/given_setting.h"
#include "planish/job/job_progress.h"
#include "planish/job/job_settings.h"
#include "planish/job/output_plan.h"
#include "planish/job/report.h"
#include "planish/job/sampling.h"
#include "planish/job/scene_move.h"
#include "planish/reconstruct/reconstruct.h"

namespace planish {

class JobPage;  // job_page.h

/// One piece of work: a mesh or points in, the surface and reports out.
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
  std::function<Mesher()> mesher;      ///< where points are; empty: require_mesher()
  std::vector<std::string> arguments;  ///< argv, for the report
  std::string source;                  ///< mesh that the surface is compared with; empty: the input
  std::string report;                  ///< path, "-" for stdout, empty for none
  std::string page;                    ///< the same
  bool overwrites = false;             ///< files that exist
};

/// A surface by the settings' fineness, with their levels of detail.
[[nodiscard]] OutputRequest surface_request(const Settings& settings, std::string path,
                                            std::string where);

/// The files of a job, claimed, and tested for what they are to hold. Runs every test by `note`,
/// which may keep the Error that it throws.
[[nodiscard]] std::vector<PlannedOutput> plan_outputs(
    Job& job, PathClaims& claims, const std::function<void(const std::function<void()>&)>& note);

/// How a job talks to who runs it. Every member may be empty. Called on the calling thread only.
struct JobWatch {
  ProgressVisit progress{};
  std::function<bool()> cancelled{};
  /// Of several meshes of an asset one for each kind.
  std::function<void(const Warning&)> warning{};
  /// Lines on how it was computed, for who looks for causes.
  std::function<void(const std::string&)> details{};
  /// Takes what is for stdout: the surface before any file is in place, report and page after.
  std::function<void(std::string_view bytes)> write{};
  JobPage* page = nullptr;  ///< is shown the surface
};

/// What a job's steps share.
struct JobContext {
  const JobWatch& watch;
  JobProgress& progress;

  [[nodiscard]] bool wants_page() const { return watch.page != nullptr; }
};

struct JobResult {
  JobReport report;
  std::vector<FittedMesh> fitted;  ///< one; of an asset all that surfaces were made of
};

/// Reads, checks, fits, evaluates the levels, writes, reports. Files appear all together at the
/// end or, after an error, not at all. Not converging is a result, which the report says.
/// Throws planish::Error.
JobResult run_job(const Job& job, const std::vector<PlannedOutput>& outputs, Backend& backend,
                  const JobWatch& watch);

}  // namespace planish
