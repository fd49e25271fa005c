// planish-mpi: `planish fit` of a mesh that no single machine has to hold.
#include <mpi.h>

#include <cstdio>
#include <exception>
#include <memory>

#include "mpi_flags.h"
#include "mpi_report.h"
#include "planish/core/output_file.h"

namespace planish::command {
namespace {

void say(const Ranks& ranks, const std::string& text) {
  if (ranks.rank == 0) std::fputs(text.c_str(), stderr);
}

ExitCode fit_job(const Ranks& ranks, const std::vector<std::string>& arguments) {
  MpiJob job;
  agree(ranks, [&] { job = parse_mpi_flags(arguments); });
  if (!job.text.empty()) {
    if (ranks.rank == 0) std::fputs(job.text.c_str(), stdout);
    return ExitCode::Done;
  }
  agree(ranks, [&] {
    if (ranks.rank == 0) require_writable(job);
  });
  JobWatch watch(ranks.rank, job.watchdog_seconds);
  ExitCode code = ExitCode::Done;
  // Opened before the cage is in place, so that both are there or none.
  std::unique_ptr<OutputFile> report;
  const DistributedFit fit = fit_distributed(
      ranks, [&] { return read_slices(ranks, job.input, job.input_format); }, job.options, watch,
      [&](const DistributedFit& done) {
        code = done.solution.converged ? ExitCode::Done : ExitCode::NotConverged;
        agree(ranks, [&] {
          if (ranks.rank != 0 || job.report.empty()) return;
          report = std::make_unique<OutputFile>(job.report);
          report->write(mpi_report(arguments, job, done, code));
        });
      });
  agree(ranks, [&] {
    if (report) report->commit();
  });
  for (const Warning& warning : fit.warnings) say(ranks, "warning: " + warning.message + "\n");
  say(ranks, mpi_summary(job, fit));
  return code;
}

}  // namespace
}  // namespace planish::command

int main(int argc, char** argv) {
  using namespace planish;
  using namespace planish::command;
  int provided = 0;
  // The watchdog's thread and those of the kernels do not talk to MPI.
  MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);
  const Ranks ranks(MPI_COMM_WORLD);
  const std::vector<std::string> arguments(argv, argv + argc);
  ExitCode code = ExitCode::InternalError;
  try {
    const PetscSession petsc;
    code = fit_job(ranks, arguments);
  } catch (const AgreedError& error) {
    say(ranks, std::string("planish-mpi: error: ") + error.what() + "\n");
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
