#include "planish/pipeline/fit_report.h"
#include "bindings.h"
#include "planish/core/json.h"
#include "planish/core/version.h"
#include "planish/mesh/folded_edges.h"
#include "planish/mesh/statistics.h"
#include "planish/surface/block_quality.h"
#include "planish/surface/surface_quality.h"

namespace py = pybind11;

namespace planish::python {
namespace {

// As `planish fit --report` has it: numbers that are none become None.
py::object python_of(const nlohmann::ordered_json& json) {
  using Json = nlohmann::ordered_json;
  return py::module_::import("json").attr("loads")(
      json.dump(-1, ' ', false, Json::error_handler_t::replace));
}

nlohmann::ordered_json input_of(const FittedMesh& fitted) {
  const PreparedMesh& prepared = *fitted.fit.prepared;
  const FoldedEdges folds = folded_edges(fitted.mesh, *prepared.topology);
  return input_json(fitted.figures(), statistics(prepared), folds.count, folds.area);
}

py::dict timing_of(const PythonFit& fit) {
  const FitTiming& timing = fit.fitted.fit.timing;
  py::dict result;
  result["check"] = timing.check;
  result["topology"] = timing.topology;
  result["stencils"] = timing.stencils;
  result["upload"] = timing.upload;
  result["solve"] = timing.solve;
  result["total"] = 1e3 * fit.seconds;
  return result;
}

}  // namespace

py::dict report_of(const PythonFit& fit) {
  py::dict report, tool;
  tool["name"] = "planish";
  tool["version"] = PLANISH_VERSION;
  report["tool"] = tool;
  report["input"] = python_of(input_of(fit.fitted));
  report["solve"] = python_of(solve_json(fit.fitted.figures()));
  report["timing_ms"] = timing_of(fit);
  report["warnings"] = python_of(warnings_json(fit.fitted.warnings));
  return report;
}

py::dict quality_of(const PythonFit& fit, int level) {
  const FittedMesh& fitted = fit.fitted;
  const auto measured = [&](int at, const Callbacks& callbacks) {
    EvaluateOptions options = fitted.evaluate_options(at);
    options.callbacks = callbacks;
    if (fitted.options.scheme == Scheme::DooSabin) {
      const auto surface = fitted_surface(fitted.mesh, fitted.fit, options);
      const auto folds = folded_edges(fitted.mesh, *fitted.fit.prepared->topology);
      return surface_quality(*surface->level(at), fitted.mesh, folds.is_beside, callbacks);
    }
    const auto backend = make_cpu_backend({.thread_count = fit.threads});
    return surface_quality(evaluate(fitted.mesh, fitted.fit, *backend, options), fitted.mesh);
  };
  SurfaceQuality quality;
  run_released(
      {},
      [&](const Callbacks& callbacks) {
        require_level(level);
        quality = measured(level, callbacks);
        if (level == kBendingLevel) return;
        const SurfaceQuality* const known = fitted.chosen_quality();
        quality.bending = known ? known->bending : measured(kBendingLevel, callbacks).bending;
      },
      fit.threads);
  return py::dict(python_of(quality_json(quality, level)));
}

}  // namespace planish::python
