#include "job/job_fit.h"

#include <algorithm>

#include "job/prepare.h"
#include "job/timed.h"
#include "planish/mesh/check.h"
#include "planish/pipeline/fit_best.h"
#include "terminal/text.h"

namespace planish::command {
namespace {

FitOptions options_of(const JobInput& made, const JobReport& report, const Callbacks& callbacks) {
  FitOptions options = fit_options(report.settings, report.method);
  options.prepared = made.prepared;
  options.callbacks = callbacks;
  return options;
}

double sum_of(const FitTiming& timing) {
  return timing.check + timing.topology + timing.stencils + timing.upload + timing.solve;
}

Fit choose_fit(JobInput& made, Backend& backend, JobReport& report, const JobContext& context) {
  const FitOptions options = options_of(made, report, callbacks_for(report, context));
  ReadyMesh ready;
  const auto make_fair_mesh = [&] {
    ready = prepare(std::move(*made.unprepared), report.settings, InterpolationMethod::Fair);
    return FairMesh{std::move(ready.mesh), ready.prepared, std::move(ready.found)};
  };
  BestFit best = timed(report.timing.choose, [&] {
    return fit_best(made.input.file.mesh, backend, options, make_fair_mesh);
  });
  report.timing.choose -= sum_of(best.fit.timing);
  report.choice = MethodChoice{best.reason, best.progressive, best.fair};
  report.smoothed_vertices = std::move(best.smoothed_vertices);
  if (best.fair_mesh)
    take_fair_mesh(made, std::move(*best.fair_mesh), std::move(ready), report, context.console);
  made.unprepared.reset();
  return std::move(best.fit);
}

Fit run_fit(JobInput& made, Backend& backend, JobReport& report, const JobContext& context) {
  try {
    if (made.unprepared) return choose_fit(made, backend, report, context);
    const FitOptions options = options_of(made, report, callbacks_for(report, context));
    if (!made.found) return fit(made.input.file.mesh, backend, options);
    CreasedFit creased =
        fit_with_found_creases(made.input.file.mesh, *made.found, backend, options);
    report.smoothed_vertices = std::move(creased.smoothed_vertices);
    return std::move(creased.fit);
  } catch (const Error& error) {
    // fit() knows no file name: say it again with the name.
    if (error.code() != ErrorCode::UnusableMesh) throw;
    require_usable(made.input.file.mesh, made.input.name);
    throw Error(error.code(), made.input.name + ": " + error.what(), error.element());
  }
}

void note_fit(JobReport& report, Fit& result) {
  report.input.sharp_edges = result.sharp_edge_count;
  report.input.corners = result.corner_count;
  report.spectral_bound = result.spectral_bound;
  report.timing.check += result.timing.check;
  report.timing.topology += result.timing.topology;
  report.timing.stencils += result.timing.stencils;
  report.timing.upload += result.timing.upload;
  report.timing.solve += result.timing.solve;
  if (result.fair) {
    report.fair = FairFigures{result.fair->shrunk_vertices, result.fair->reversed_vertices,
                              result.fair->cured_vertices, result.fair->flagged_edges,
                              result.fair->flagged_faces};
  }
  report.interpolation = std::move(result.interpolation);
  report.interpolation.displacement.clear();
}

std::string remedy(const JobReport& report) {
  if (report.method == InterpolationMethod::Fair) return "raise --tolerance";
  switch (report.interpolation.stop_reason) {
    case StopReason::Singular:
      return "this scheme has no surface through these vertices, as can be where three faces meet "
             "at every vertex; take --scheme doo-sabin, which always has one";
    case StopReason::Diverged:
      return "the iteration drives the error up on this mesh; take --scheme doo-sabin, whose error "
             "always falls";
    default:
      return "raise --max-iterations or --tolerance";
  }
}

void warn_of_the_solve(JobReport& report, Console& console) {
  const Interpolation& result = report.interpolation;
  if (result.converged) return;
  report.exit_code = ExitCode::NotConverged;
  const bool iterates = report.method == InterpolationMethod::Progressive;
  add_warning(report, console,
              {"not-converged",
               report.input.path + ": not converged (" + planish::name_of(result.stop_reason) +
                   "): the error is " + short_number(result.error.max) +
                   (iterates ? " after " + counted(result.iterations, "iteration") : "") +
                   ", the tolerance " + short_number(report.settings.tolerance) +
                   "; what is written says so; " + remedy(report),
               1, result.worst_vertex});
}

void warn_of_unused(JobReport& report, const PreparedMesh& mesh, Console& console) {
  const std::int64_t count = report.input.statistics.unused_vertex_count;
  if (count == 0) return;
  std::int64_t first = 0;
  while (first < std::ssize(mesh.vertices) && mesh.vertices[first] == first) ++first;
  add_warning(
      report, console,
      {"unused-vertices",
       report.input.path + ": " + with_separators(count) + " of " +
           with_separators(mesh.given_vertex_count) + " vertices belong to no face (the first is " +
           std::to_string(first) + "); they stay where they are in the cage",
       count, first});
}

}  // namespace

Fit fit_input(JobInput& made, Backend& backend, JobReport& report, const JobContext& context) {
  Fit result = run_fit(made, backend, report, context);
  timed(report.timing.check, [&] {
    report.input.statistics = statistics(*result.prepared);
    made.folds = folded_edges(made.input.file.mesh, *result.prepared->topology);
  });
  report.input.folded_edges = made.folds.count;
  report.input.folded_edge_area = made.folds.area;
  note_fit(report, result);
  warn_of_unused(report, *result.prepared, context.console);
  warn_of_the_solve(report, context.console);
  return result;
}

}  // namespace planish::command
