#include <string>

#include "bindings.h"
#include "planish/core/version.h"
#include "planish/mesh/folded_edges.h"
#include "planish/mesh/statistics.h"
#include "planish/pipeline/make_ready.h"
#include "planish/pipeline/option_words.h"
#include "planish/surface/block_quality.h"
#include "planish/surface/surface_quality.h"

namespace py = pybind11;

namespace planish::python {
namespace {

py::str text_of(std::string_view text) { return py::str(text.data(), text.size()); }

py::dict norms_of(const ErrorNorms& norms) {
  py::dict result;
  result["max"] = norms.max;
  result["rms"] = norms.rms;
  return result;
}

py::dict input_of(const FittedMesh& fitted) {
  const Fit& fit = fitted.fit;
  const MeshStatistics facts = statistics(*fit.prepared);
  const FoldedEdges folds = folded_edges(fitted.mesh, *fit.prepared->topology);
  py::dict sizes, folded, result;
  for (std::size_t n = 0; n < facts.face_size_counts.size(); ++n)
    if (facts.face_size_counts[n] != 0)
      sizes[py::str(std::to_string(n))] = facts.face_size_counts[n];
  folded["count"] = folds.count;
  folded["area"] = folds.area;
  result["vertices"] = facts.vertex_count;
  result["faces"] = facts.face_count;
  result["face_sizes"] = sizes;
  result["boundary_loops"] = facts.boundary_loop_count;
  result["components"] = facts.component_count;
  result["genus"] = facts.genus;
  result["sharp_edges"] = fit.sharp_edge_count;
  result["corners"] = fit.corner_count;
  result["folded_edges"] = folded;
  result["separated_edges"] = fitted.separated_edges.size();
  py::list changed;
  for (const std::int32_t face : fitted.changed_faces) changed.append(face);
  result["changed_faces"] = changed;
  return result;
}

py::object choice_of(const std::optional<MethodReason>& reason) {
  if (!reason) return py::none();
  const auto figures = [](const std::optional<SurfaceQuality>& quality) -> py::object {
    if (!quality) return py::none();
    py::dict result;
    result["folded_area_elsewhere"] = quality->folded_area_elsewhere;
    result["rms_normal_deviation"] = quality->rms_normal_deviation;
    return result;
  };
  py::dict result;
  result["reason"] = reason->text;
  result["progressive"] = figures(reason->progressive);
  result["fair"] = figures(reason->fair);
  return result;
}

py::object fair_of(const FittedMesh& fitted) {
  if (!fitted.fit.fair) return py::none();
  const FairFit& fair = *fitted.fit.fair;
  py::dict result;
  result["polish"] = fitted.options.polish_steps;
  result["shrunk_vertices"] = fair.shrunk_vertices;
  result["reversed_vertices"] = fair.reversed_vertices;
  result["cured_vertices"] = fair.cured_vertices;
  result["smoothed_vertices"] = fitted.smoothed_vertices.size();
  result["flagged_edges"] = fair.flagged_edges;
  result["flagged_faces"] = fair.flagged_faces;
  return result;
}

py::dict solve_of(const FittedMesh& fitted) {
  const FitOptions& options = fitted.options;
  const Interpolation& result = fitted.fit.interpolation;
  const bool iterates = options.method == InterpolationMethod::Progressive;
  const auto where = [](bool applies, const py::object& value) {
    return applies ? value : py::object(py::none());
  };
  py::dict solve;
  solve["method"] = text_of(word_of(kMethodWords, options.method));
  solve["choice"] = choice_of(fitted.reason);
  solve["scheme"] = text_of(word_of(kSchemeWords, options.scheme));
  solve["weights"] =
      where(options.scheme == Scheme::DooSabin, text_of(word_of(kWeightsWords, options.weights)));
  solve["solver"] = where(iterates, text_of(word_of(kSolverWords, options.solver)));
  solve["boundary"] = text_of(word_of(kBoundaryWords, options.sharp.boundary));
  solve["creases"] = fitted.creases();
  solve["repair"] = fitted.repairs ? "safe" : "none";
  solve["weld"] = where(fitted.weld.has_value(), py::float_(fitted.weld.value_or(0)));
  solve["tolerance"] = options.tolerance;
  solve["converged"] = result.converged;
  solve["stop_reason"] = name_of(result.stop_reason);
  solve["iterations"] = result.iterations;
  solve["spectral_bound"] = where(iterates, py::float_(fitted.fit.spectral_bound));
  py::dict error = norms_of(result.error);
  error["worst_vertex"] = result.worst_vertex;
  solve["error"] = error;
  py::list history;
  for (std::size_t i = 0; i < result.history.size(); ++i) {
    py::dict entry = norms_of(result.history[i]);
    entry["iteration"] = i;
    history.append(entry);
  }
  solve["history"] = history;
  solve["fair"] = fair_of(fitted);
  return solve;
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
  report["input"] = input_of(fit.fitted);
  report["solve"] = solve_of(fit.fitted);
  report["timing_ms"] = timing_of(fit);
  py::list warnings;
  for (const Warning& warning : fit.fitted.warnings) {
    py::dict entry;
    entry["code"] = warning.code;
    entry["message"] = warning.message;
    entry["count"] = warning.count;
    entry["first"] = warning.first;
    warnings.append(entry);
  }
  report["warnings"] = warnings;
  return report;
}

py::dict quality_of(const PythonFit& fit, int level) {
  const FittedMesh& fitted = fit.fitted;
  SurfaceQuality quality;
  run_released({}, [&](const Callbacks& callbacks) {
    require_level(level);
    EvaluateOptions options = fitted.evaluate_options(level);
    options.callbacks = callbacks;
    if (fitted.options.scheme == Scheme::DooSabin) {
      const auto surface = fitted_surface(fitted.mesh, fitted.fit, options);
      const auto folds = folded_edges(fitted.mesh, *fitted.fit.prepared->topology);
      quality = surface_quality(*surface->level(level), fitted.mesh, folds.is_beside, callbacks);
      return;
    }
    const auto backend = make_cpu_backend({.thread_count = fit.threads});
    quality = surface_quality(evaluate(fitted.mesh, fitted.fit, *backend, options), fitted.mesh);
  });
  py::dict result;
  result["level"] = level;
  result["reference"] = "input";
  result["folded_area"] = quality.folded_area;
  result["folded_area_elsewhere"] = quality.folded_area_elsewhere;
  result["rms_normal_deviation"] = quality.rms_normal_deviation;
  result["max_normal_deviation"] = quality.max_normal_deviation;
  result["bending"] = quality.bending;
  return result;
}

}  // namespace planish::python
