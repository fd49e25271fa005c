// planish-mpi: `planish fit` and `planish run` of meshes that no single machine has to hold.
#include <mpi.h>

#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <utility>

#include "mpi_job.h"
#include "planish/core/error.h"
#include "planish/core/output_file.h"
#include "planish/core/words.h"
#include "planish/job/job_text.h"
#include "scene_file.h"

namespace planish::command {
namespace {

// What all jobs of the process share. Rank 0 alone says anything.
struct Process {
  const Ranks& ranks;
  const std::vector<std::string>& arguments;
  MpiRequest request;
  Console console;
};

// Rank 0 reads, the others get what it read.
std::vector<Job> jobs_of_scene(const Ranks& ranks, const MpiRequest& request) {
  std::string text;
  agree(ranks, [&] {
    if (ranks.rank == 0) text = read_scene_text(request.scene);
  });
  auto size = static_cast<std::int64_t>(text.size());
  MPI_Bcast(&size, 1, MPI_INT64_T, 0, ranks.comm);
  text.resize(static_cast<std::size_t>(size));
  MPI_Bcast(text.data(), static_cast<int>(size), MPI_CHAR, 0, ranks.comm);
  std::vector<Job> jobs;
  agree(ranks, [&] {
    const std::filesystem::path path = request.scene;
    jobs = select_jobs(parse_scene(text, visible(path), path.parent_path()), request.names);
  });
  return jobs;
}

std::vector<MpiJob> planned_jobs(const Ranks& ranks, const MpiRequest& request) {
  const std::vector<Job> jobs = request.own.is_scene ? jobs_of_scene(ranks, request) : request.jobs;
  std::vector<MpiJob> planned;
  agree(ranks, [&] {
    for (const Job& job : jobs) planned.push_back(mpi_job_of(job, request.own));
    if (ranks.rank == 0) claim_files(planned, request.scene, request.own);
  });
  return planned;
}

// How far the ranks are, shown by rank 0; null where nobody wants to know.
std::unique_ptr<RankProgress> progress_of(const Process& process, JobProgress& shown) {
  constexpr double kSeconds = 1;  // between two sums over all ranks
  const MessageFlags& messages = process.request.messages;
  const bool is_wanted =
      messages.progress_mode() != ProgressMode::None &&
      (messages.progress_mode() != ProgressMode::Auto || messages.level() >= LogLevel::Info);
  if (!is_wanted) return nullptr;
  return std::make_unique<RankProgress>(
      process.ranks, kSeconds,
      [&shown](std::string_view phase, double fraction) { shown.update(phase, fraction); });
}

ExitCode fit_job(Process& process, const MpiJob& job, RankProgress* progress) {
  const Ranks& ranks = process.ranks;
  agree(ranks, [&] {
    if (ranks.rank == 0) make_folders(job);
  });
  RankWatch watch(ranks.rank, process.request.own.watchdog_seconds, progress);
  ExitCode code = ExitCode::Done;
  // Opened before the cage is in place, so that both are there or none.
  std::unique_ptr<OutputFile> file;
  std::string report;
  const DistributedFit fit = fit_distributed(
      ranks, [&] { return read_slices(ranks, job.input, job.input_format); }, job.options, watch,
      [&](const DistributedFit& done) {
        code = done.solution.converged ? ExitCode::Done : ExitCode::NotConverged;
        agree(ranks, [&] {
          if (ranks.rank != 0 || job.report.empty()) return;
          report = mpi_report(process.arguments, job, done, code);
          if (job.report == "-") return;
          file = std::make_unique<OutputFile>(job.report, process.request.own.force);
          file->write(report);
        });
      });
  agree(ranks, [&] {
    if (file) file->commit();
    if (ranks.rank == 0 && job.report == "-") write_stdout(report);
  });
  if (ranks.rank != 0) return code;
  process.console.clear_status();
  for (const Warning& warning : fit.warnings) process.console.warning(warning.message);
  process.console.info(mpi_summary(job, fit));
  return code;
}

// With the error that all ranks agree on.
ExitCode run_job(Process& process, const MpiJob& job, int number, int count) {
  Progress progress(process.console, process.request.messages.progress_mode(), {}, count);
  JobDisplay display(progress, job.name, number);
  JobProgress shown(display.visit());
  shown.plan(steps_of(job));
  const std::unique_ptr<RankProgress> ranks = progress_of(process, shown);
  ExitCode code = ExitCode::InternalError;
  try {
    code = fit_job(process, job, ranks.get());
  } catch (const AgreedError& error) {
    if (ranks) ranks->finish();
    code = exit_code_of(error.code());
    if (process.ranks.rank == 0)
      process.console.error((count > 1 ? "job " + job.name + ": " : "") + error.what());
    return code;
  }
  if (ranks) ranks->finish();
  return code;
}

ExitCode run_all(Process& process) {
  const std::vector<MpiJob> jobs = planned_jobs(process.ranks, process.request);
  const int count = static_cast<int>(jobs.size());
  int failed = 0;
  ExitCode code = ExitCode::Done;
  for (int i = 0; i < count; ++i) {
    code = run_job(process, jobs[i], i + 1, count);
    if (code != ExitCode::Done) ++failed;
  }
  if (!process.request.own.is_scene || failed == 0)
    return process.request.own.is_scene ? ExitCode::Done : code;
  if (process.ranks.rank == 0)
    process.console.error(formatted("{} of {} failed", failed, counted(count, "job")));
  return ExitCode::JobsFailed;
}

ExitCode run_arguments(const Ranks& ranks, const std::vector<std::string>& arguments) {
  MpiRequest request;
  agree(ranks, [&] { request = parse_mpi_flags(arguments); });
  if (!request.text.empty()) {
    if (ranks.rank == 0) std::fputs(request.text.c_str(), stdout);
    return ExitCode::Done;
  }
  const MessageFlags messages = request.messages;
  Process process{ranks,
                  arguments,
                  std::move(request),
                  {messages.level(), messages.color_mode(), messages.form(), "planish-mpi"}};
  return run_all(process);
}

}  // namespace
}  // namespace planish::command

int main(int argc, char** argv) {
  using namespace planish;
  using namespace planish::command;
  const std::vector<std::string> arguments(argv, argv + argc);
  if (argc > 1 && arguments[1] == "manual") {  // the build has no ranks
    std::fputs(parse_mpi_flags(arguments).text.c_str(), stdout);
    return 0;
  }
  int provided = 0;
  // The watchdog's thread and those of the kernels do not talk to MPI.
  MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);
  const Ranks ranks(MPI_COMM_WORLD);
  ExitCode code = ExitCode::InternalError;
  try {
    const PetscSession petsc;
    code = run_arguments(ranks, arguments);
  } catch (const AgreedError& error) {
    const MessageStyle style = early_style(arguments);
    if (ranks.rank == 0)
      Console(LogLevel::Error, style.color, style.form, "planish-mpi").error(error.what());
    code = exit_code_of(error.code());
  } catch (const std::exception& error) {
    // What ranks have not agreed on leaves the others waiting.
    std::fprintf(stderr, "planish-mpi: rank %d: %s\n", ranks.rank, error.what());
    std::fflush(stderr);
    MPI_Abort(MPI_COMM_WORLD, static_cast<int>(ExitCode::InternalError));
  }
  MPI_Finalize();
  return static_cast<int>(code);
}
