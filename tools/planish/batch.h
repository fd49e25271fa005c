#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "devices.h"
#include "planish/job/job.h"
#include "planish/job/page/page.h"
#include "terminal.h"

namespace planish::command {

/// A job whose files and device are settled.
struct PlannedJob {
  Job job;
  std::vector<PlannedOutput> outputs;
  std::size_t device = 0;  ///< position in the list of devices
};

/// The files that a job writes, claimed, and tested for what they are to hold; what is wrong goes
/// to `faults`.
void claim_outputs(PlannedJob& planned, PathClaims& claims, Faults& faults);

struct BatchOptions {
  int workers = 1;  ///< jobs at once
  ProgressMode progress = ProgressMode::None;
  std::vector<std::string> arguments;  ///< argv, for the reports
  PageOptions page;
  bool wants_page = false;    ///< one of all jobs
  bool wants_sheet = false;   ///< a contact sheet of them
  bool wants_report = false;  ///< the same
};

/// What became of a job.
struct JobOutcome {
  std::optional<JobReport> report;  ///< empty: it failed, and the message has been given
  ExitCode exit_code = ExitCode::Done;
  std::string message;             ///< of the failure
  std::vector<PageJob> page_jobs;  ///< its part of a page of all jobs
  SmallPictures pictures;          ///< of a contact sheet
};

/// Asks for devices as far as the jobs can take them, and notes each job's. Throws as
/// choose_device().
[[nodiscard]] DeviceList settle_devices(std::vector<PlannedJob>& jobs);

/// Runs every job, whatever becomes of the others; the outcomes in the order of the jobs, the same
/// for any number of workers. A backend is opened once for all jobs of a worker that share a device
/// and a precision. Throws Error{Cancelled}.
[[nodiscard]] std::vector<JobOutcome> run_batch(const std::vector<PlannedJob>& jobs,
                                                const DeviceList& devices, Console& console,
                                                const BatchOptions& options);

/// Done where every job is; JobsFailed otherwise.
[[nodiscard]] ExitCode exit_code_of(const std::vector<JobOutcome>& outcomes);

/// One line a job, and what the columns mean.
[[nodiscard]] std::string batch_table(const std::vector<PlannedJob>& jobs,
                                      const std::vector<JobOutcome>& outcomes);

/// The same of many files: how good the surface of each is, in 100 columns.
[[nodiscard]] std::string files_table(const std::vector<PlannedJob>& jobs,
                                      const std::vector<JobOutcome>& outcomes);

/// "2 of 5 jobs failed", or how many did not converge.
[[nodiscard]] std::string failed_jobs_text(const std::vector<JobOutcome>& outcomes);

/// Writes it to the path, "-" for stdout. Throws Error{UnwritableOutput}.
void write_batch_report(const std::string& path, const nlohmann::ordered_json& json,
                        bool overwrites);

/// Writes the page of all jobs to the path, "-" for stdout, and says so. Throws
/// Error{UnwritableOutput}.
void write_batch_page(const std::string& path, std::vector<JobOutcome>& outcomes,
                      const PageOptions& options, Console& console, bool overwrites);

/// Writes a contact sheet of all jobs to the path, with links to their pages, and says so. Throws
/// Error{UnwritableOutput}. `kind`: what they are, "file".
void write_batch_sheet(const std::string& path, const std::vector<PlannedJob>& jobs,
                       std::vector<JobOutcome>& outcomes, const PageOptions& options,
                       Console& console, bool overwrites, std::string_view kind);

/// Schema planish.batch/1: the reports of all jobs, those that failed with their message, and their
/// names as the contact sheet has them.
[[nodiscard]] nlohmann::ordered_json batch_json(const std::vector<PlannedJob>& jobs,
                                                const std::vector<JobOutcome>& outcomes,
                                                const std::vector<std::string>& arguments);

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
