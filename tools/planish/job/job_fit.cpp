#include "job/job_fit.h"

#include <utility>

#include "job/apply_moves.h"
#include "job/timed.h"
#include "planish/core/formatted.h"
#include "planish/core/refuse.h"
#include "planish/pipeline/fit_report.h"
#include "terminal/text.h"

namespace planish::command {
namespace {

void note_fit(JobReport& report, FittedMesh& fitted) {
  report.method = fitted.options.method;
  report.choice = fitted.reason;
  report.quad_reason = fitted.quad_reason;
  if (fitted.refine_reason) report.refinement = fitted.refine_reason->text;
  CreaseChoice& creases = report.settings.creases;
  creases.chooses = false;
  creases.finds_features = fitted.finds_features;
  creases.dihedral_degrees = fitted.crease_degrees;
  report.found_edges =
      fitted.crease_degrees || fitted.finds_features ? std::ssize(fitted.mesh.creases) : 0;
  report.input.joined = fitted.paired_count;
  report.density = fitted.density;
  report.settings.quads = fitted.pairs_triangles ? QuadChoice::On : QuadChoice::Off;
  report.input.added = std::ssize(fitted.added_vertices);
  report.settings.refine = report.input.added > 0 ? RefineChoice::On : RefineChoice::Off;
  if (fitted.fit.within) {
    report.settings.within = {.of_diagonal = fitted.fit.within->within};
    report.within = fitted.fit.within;
  }
  report.smoothed_vertices = fitted.smoothed_vertices;
  report.input.welded += fitted.welded_count;
  report.input.separated_edges = std::ssize(fitted.separated_edges);
  report.timing.choose = fitted.choose_milliseconds;
  Fit& result = fitted.fit;
  report.spectral_bound = result.spectral_bound;
  report.timing.check += result.timing.check;
  report.timing.topology += result.timing.topology;
  report.timing.stencils += result.timing.stencils;
  report.timing.upload += result.timing.upload;
  report.timing.solve += result.timing.solve;
  if (result.fair) report.fair = *result.fair;
  report.solve = solve_json(fitted);
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
               formatted("{}: not converged ({}): the error is {}{}, the tolerance {}; what is "
                         "written says so; {}",
                         input_name(report.input.path), planish::name_of(result.stop_reason),
                         short_number(result.error.max),
                         iterates ? " after " + counted(result.iterations, "iteration") : "",
                         short_number(report.settings.tolerance), remedy(report)),
               1, result.worst_vertex});
}

}  // namespace

void fit_input(JobInput& made, ReadyFit&& ready, Backend& backend, std::span<const SceneMove> moves,
               JobReport& report, const JobContext& context) {
  context.progress.update("fit", 0);
  made.fitted = fit_prepared(std::move(ready), backend);
  made.fitted.split_normals = report.settings.creases.split_normals;
  if (!moves.empty()) {
    if (!report.reconstruction.is_null())
      refuse(moves.front().where, "moves are of vertices of a mesh; the input holds points");
    report.moved =
        timed(made.fitted.fit.timing.solve, [&] { return apply_moves(made.fitted, moves); });
  }
  const PreparedMesh& prepared = *made.fitted.fit.prepared;
  timed(report.timing.check, [&] {
    report.input.statistics = statistics(prepared);
    made.folds = folded_edges(made.fitted.mesh, *prepared.topology);
  });
  report.input.folded_edges = made.folds.count;
  report.input.folded_edge_area = made.folds.area;
  report.input.mesh = input_json(made.fitted, report.input.statistics, made.folds);
  note_fit(report, made.fitted);
  warn_of_the_solve(report, context.console);
}

}  // namespace planish::command
