#include "job/job_fit.h"

#include <utility>

#include "job/apply_moves.h"
#include "job/timed.h"
#include "planish/core/formatted.h"
#include "planish/core/refuse.h"
#include "planish/mesh/inside_out.h"
#include "planish/pipeline/fit_report.h"
#include "terminal/text.h"

namespace planish::command {
namespace {

void note_fit(JobReport& report, FittedMesh& fitted) {
  report.method = fitted.options.method;
  report.choice = fitted.reason;
  report.quad_reason = fitted.quad_reason;
  CreaseChoice& creases = report.settings.creases;
  report.tried_creases = report.choice && creases.chooses;
  creases.chooses = false;
  creases.dihedral_degrees = fitted.crease_degrees;
  report.input.joined = fitted.paired_count;
  report.density = fitted.density;
  report.settings.quads = fitted.pairs_triangles ? QuadChoice::On : QuadChoice::Off;
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

void warn_of_unused(JobReport& report, const PreparedMesh& mesh, Console& console) {
  const std::int64_t count = report.input.statistics.unused_vertex_count;
  if (count == 0) return;
  std::int64_t first = 0;
  while (first < std::ssize(mesh.vertices) && mesh.vertices[first] == first) ++first;
  add_warning(report, console,
              {"unused-vertices",
               formatted("{}: {} of {}{}{}); {} in the cage", input_name(report.input.path),
                         with_separators(count), counted(mesh.given_vertex_count, "vertex"),
                         count == 1 ? " belongs to no face (" : " belong to no face (the first is ",
                         first, count == 1 ? "it stays where it is" : "they stay where they are"),
               count, first});
}

// Whoever draws front faces alone shows nothing of such parts from outside, or their far sides.
void warn_of_inside_out_parts(const FittedMesh& made, JobReport& report, Console& console) {
  const PreparedMesh& prepared = *made.fit.prepared;
  if (!prepared.uses_all()) return;
  const InsideOutParts found =
      inside_out_parts(made.mesh, *prepared.topology, report.input.statistics.component_count);
  if (found.count == 0) return;
  const std::int64_t face = made.source_faces.empty()
                                ? found.first_face
                                : made.source_faces[static_cast<std::size_t>(found.first_face)];
  add_warning(
      report, console,
      {"inside-out",
       formatted("{}: closed parts whose faces look inward: {}, first at face {}; renderers "
                 "that draw front faces alone show them from inside; turn the faces over "
                 "where that is not meant",
                 input_name(report.input.path), with_separators(found.count), face),
       found.count, face});
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
  warn_of_unused(report, prepared, context.console);
  if (report.reconstruction.is_null())
    warn_of_inside_out_parts(made.fitted, report, context.console);
  warn_of_the_solve(report, context.console);
}

}  // namespace planish::command
