#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/files/mesh_file.h"
#include "planish/job/job_settings.h"
#include "planish/job/output_plan.h"
#include "planish/job/report.h"
#include "planish/reconstruct/reconstruct.h"
#include "planish/solve/backend.h"

namespace planish {

/// A step of a job and how long it takes beside the others, in any unit.
struct PlannedStep {
  std::string name;
  double weight = 1;
};

/// What is told of a job: the `fraction` of the step, 0 to 1, and the `share` of the whole job,
/// which never falls.
using ProgressVisit = std::function<void(std::string_view step, double fraction, double share)>;

/// How far a job is, of the steps that it will take.
class JobProgress {
 public:
  /// `visit` may be empty.
  explicit JobProgress(ProgressVisit visit) : visit_(std::move(visit)) {}

  /// The steps to come, in order; others are parts of the one under way, with its fraction.
  void plan(std::vector<PlannedStep> steps) { steps_ = std::move(steps); }
  void update(std::string_view step, double fraction);
  /// While it lives, fractions are those of a part of each step: from `begin` to `end`.
  class Part {
   public:
    Part(JobProgress& progress, double begin, double end) : progress_(progress) {
      progress_.begin_ = begin;
      progress_.end_ = end;
    }
    ~Part() {
      progress_.begin_ = 0;
      progress_.end_ = 1;
    }
    Part(const Part&) = delete;
    Part& operator=(const Part&) = delete;

   private:
    JobProgress& progress_;
  };
  /// Of the whole job, 0 to 1; never falls.
  [[nodiscard]] double share() const { return share_; }

 private:
  void advance();

  ProgressVisit visit_;
  std::vector<PlannedStep> steps_{};
  std::size_t place_ = 0;  ///< in steps_
  std::string step_{};
  double fraction_ = 0, share_ = 0;
  double begin_ = 0, end_ = 1;
};

class JobPage;  // page/page.h

/// What a user may say of a page.
struct PageOptions {
  std::uint64_t limit_bytes = std::uint64_t{8} << 20;
  /// Without times and memory the same run gives the same bytes.
  bool times = true;
  /// Also makes small pictures so wide, two thirds as high, as contact sheets have; 0: none.
  int small_width = 0;
};

/// One piece of work: a mesh or points in, the surface and reports out.
struct Job {
  std::string name;   ///< in tables, of progress
  std::string label;  ///< what messages begin with: a scene's job's name, else that of the input
  std::string input;  ///< path, or "-" for stdin
  std::optional<FileFormat> input_format;  ///< empty: by extension, else by content
  Settings settings;
  std::vector<SceneMove> moves;  ///< after the fit
  std::vector<OutputRequest> outputs;
  /// Names of the settings that flags gave, for a warning where one has no effect.
  std::vector<std::string> given_settings;
  /// Settings, "moves", "source" and "page" of a scene file as they stand there, those of
  /// the defaults first.
  std::vector<GivenSetting> given;
  std::function<Mesher()> mesher;      ///< where points are; empty: require_mesher()
  std::vector<std::string> arguments;  ///< argv, for the report
  std::string source;                  ///< mesh that the surface is compared with; empty: the input
  std::string report;                  ///< path, "-" for stdout, empty for none
  std::string page;                    ///< HTML; the same
  PageOptions page_options{};
  WorkLimits limits{};
  bool digests = true;         ///< SHA-256 of what is read and written: for reports
  bool measures = true;        ///< how good the surface is
  bool overwrites = false;     ///< files that exist
  bool makes_folders = false;  ///< that its files are to be in, where run() claims them
};

/// Whether a report or a page of its own is made.
[[nodiscard]] inline bool is_reported(const Job& job) {
  return !job.report.empty() || !job.page.empty();
}

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
  JobPage* page = nullptr;  ///< takes the job's part of a page of several
};

struct JobResult {
  JobReport report;
  std::vector<FittedMesh> fitted;  ///< one; of an asset all that surfaces were made of
};

/// Reads, checks, fits, evaluates the levels, writes, reports. Files appear all together at the
/// end or, after an error, not at all. Not converging is a result, which the report says.
/// Throws planish::Error.
JobResult run(Job job, Backend& backend, const JobWatch& watch = {});

/// The same where all outputs are planned: several jobs claim their files together.
JobResult run_job(const Job& job, const std::vector<PlannedOutput>& outputs, Backend& backend,
                  const JobWatch& watch);

}  // namespace planish
