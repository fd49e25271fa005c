#include "planish/job/job_fit.h"

#include <string>
#include <utility>

#include "planish/core/refuse.h"
#include "planish/job/apply_moves.h"
#include "planish/job/timed.h"
#include "planish/pipeline/mesh_warnings.h"

namespace planish {
namespace {

void note_fit(JobReport& report, FittedMesh& fitted) {
  report.fit = fitted.figures();
  settle(report.settings, fitted);
  report.input.welded += fitted.welded_count;
  report.timing.choose = fitted.choose_milliseconds;
  Fit& result = fitted.fit;
  report.timing.check += result.timing.check;
  report.timing.topology += result.timing.topology;
  report.timing.stencils += result.timing.stencils;
  report.timing.upload += result.timing.upload;
  report.timing.solve += result.timing.solve;
  result.interpolation.displacement = {};  // nobody needs it any more
}

}  // namespace

void fit_input(JobInput& made, ReadyFit&& ready, Backend& backend, std::span<const SceneMove> moves,
               JobReport& report, const JobContext& context) {
  context.progress.update("fit", 0);
  const std::string name = ready.name;
  made.fitted = fit_prepared(std::move(ready), backend);
  made.fitted.split_normals = report.settings.creases.split_normals;
  if (!moves.empty()) {
    if (report.points)
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
  // Said of the fit where it is made; here of moves.
  if (const auto missed = convergence_warning(made.fitted, name)) {
    report.falls_short = true;
    add_warning(report, context, *missed);
  }
  note_fit(report, made.fitted);
}

void fit_cage(JobInput& made, ReadyFit&& ready, Backend& backend, std::span<const SceneMove> moves,
              JobReport& report, const JobContext& context) {
  if (has_own_cage(made.fitted)) return;
  const std::string name = ready.name;
  FittedMesh& cage = made.cage.emplace(
      timed(report.timing.choose, [&] { return fit_prepared(std::move(ready), backend); }));
  cage.split_normals = report.settings.creases.split_normals;
  if (!moves.empty()) timed(report.timing.choose, [&] { return apply_moves(cage, moves); });
  if (const auto missed = convergence_warning(cage, name + ": control cage")) {
    report.falls_short = true;
    add_warning(report, context, *missed);
  }
}

}  // namespace planish
