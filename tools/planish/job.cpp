#include "job.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "interrupt.h"
#include "job_input.h"
#include "planish/core/output_file.h"
#include "planish/core/version.h"
#include "planish/mesh/check.h"
#include "planish/reconstruct/triangle_edges.h"
#include "planish/surface/evaluate.h"
#include "planish/surface/folded_area.h"
#include "point_input.h"
#include "prepare.h"
#include "staged_files.h"
#include "surface_output.h"
#include "text.h"

namespace planish::command {
namespace {

/// A surface whose folded part is larger than this fraction of its area gets a warning.
constexpr double kFoldedAreaLimit = 1e-4;
/// Models farther from the origin than this many diagonals lose digits as float32, so they are
/// stored about their centre.
constexpr double kFarFromOrigin = 10.0;

// Runs `work` and adds the milliseconds it took to `total`.
template <class Work>
auto timed(double& total, const Work& work) {
  struct Stopwatch {
    double& total;
    std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
    ~Stopwatch() {
      total += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
                   .count();
    }
  } stopwatch{total};
  return work();
}

Fit fit_input(const Input& input, Backend& backend, JobReport& report, const Callbacks& callbacks) {
  const Settings& settings = report.settings;
  FitOptions options;
  options.weights = settings.weights;
  options.solver = settings.solver;
  options.tolerance = settings.tolerance;
  options.max_iterations = settings.max_iterations;
  options.sharp = settings.sharp();
  options.callbacks = callbacks;
  try {
    return fit(input.file.mesh, backend, options);
  } catch (const Error& error) {
    // fit() knows no file name: say it again with the name.
    if (error.code() == ErrorCode::UnusableMesh) require_usable(input.file.mesh, input.name);
    throw;
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
  report.interpolation = std::move(result.interpolation);
  report.interpolation.displacement.clear();
}

void warn_of_the_solve(JobReport& report, Console& console) {
  const Interpolation& result = report.interpolation;
  if (result.converged) return;
  report.exit_code = ExitCode::NotConverged;
  add_warning(report, console,
              {"not-converged",
               report.input.path + ": not converged (" + planish::name_of(result.stop_reason) +
                   "): the error is " + short_number(result.error.max) + " after " +
                   counted(result.iterations, "iteration") + ", the tolerance " +
                   short_number(report.settings.tolerance) +
                   "; what is written says so; raise --max-iterations or --tolerance",
               1, result.worst_vertex});
}

void warn_of_unused(JobReport& report, const PolygonMesh& mesh, Console& console) {
  const std::int64_t count = report.input.statistics.unused_vertex_count;
  if (count == 0) return;
  std::vector<bool> used(mesh.positions.size());
  for (const std::int32_t vertex : mesh.face_vertices) used[vertex] = true;
  const auto first = std::ranges::find(used, false) - used.begin();
  add_warning(
      report, console,
      {"unused-vertices",
       report.input.path + ": " + with_separators(count) + " of " +
           with_separators(mesh.vertex_count()) + " vertices belong to no face (the first is " +
           std::to_string(first) + "); they stay where they are in the cage",
       count, first});
}

void note_folds(JobReport& report, const SurfaceMesh& surface, const PolygonMesh& input,
                Console& console) {
  if (report.folded_area || surface.level == 0) return;
  report.folded_area = folded_area(surface, input);
  if (*report.folded_area <= kFoldedAreaLimit) return;
  add_warning(report, console,
              {"folded-area",
               short_number(*report.folded_area * 100) +
                   " % of the surface is folded (turned by more than 90 degrees from its face); "
                   "--interpolation fair will avoid that, but is not built yet",
               1, -1});
}

SurfaceOutputOptions surface_options(const Job& job, const JobReport& report,
                                     const Placement& placement, const PolygonMesh& input,
                                     const Callbacks& callbacks) {
  SurfaceOutputOptions options;
  options.given = input.positions;
  options.gltf.callbacks = callbacks;
  options.diagonal = placement.diagonal;
  const std::string stem =
      job.input == "-" ? job.name : std::filesystem::path(job.input).stem().string();
  options.gltf.name = plain_utf8(stem);
  options.gltf.double_sided = report.input.statistics.boundary_loop_count > 0;
  options.gltf.z_up = job.settings.up == UpAxis::Z;
  const glm::dvec3 centre = placement.centre;
  if (std::hypot(centre.x, centre.y, centre.z) > kFarFromOrigin * placement.diagonal) {
    options.gltf.origin = centre;
  }
  const Settings& settings = report.settings;
  options.gltf.extras = {{"planish", std::string(PLANISH_VERSION)},
                         {"scheme", std::string("doo-sabin")},
                         {"weights", std::string(name_of(settings.weights))},
                         {"solver", std::string(name_of(settings.solver))},
                         {"boundary", std::string(name_of(settings.boundary))},
                         {"creases", name_of(settings.creases)},
                         {"tolerance", settings.tolerance},
                         {"converged", report.interpolation.converged},
                         {"iterations", std::int64_t{report.interpolation.iterations}},
                         {"max_error", report.interpolation.error.max}};
  return options;
}

// A tolerance finer than float32 holds in the solve but not in a glTF file.
void warn_of_rounding(JobReport& report, Console& console, const WrittenOutput& output) {
  const double tolerance = report.settings.tolerance;
  if (!report.interpolation.converged || output.as_written_error <= tolerance) return;
  add_warning(report, console,
              {"rounded-output",
               output.path + ": rounding for the file leaves an error of " +
                   short_number(output.as_written_error) + ", above the tolerance " +
                   short_number(tolerance) + "; --cage and .ply keep every digit",
               1, -1});
}

struct Work {
  const Job& job;
  const std::vector<PlannedOutput>& outputs;
  Backend& backend;
  const JobContext& context;
  const PolygonMesh& input;
  const std::vector<glm::dvec3>& points;  ///< of a cloud
  const Fit& fitted;
  JobReport& report;
  StagedFiles& staged;
  std::vector<std::byte> stdout_bytes;
};

// Distances are measured on a tessellation: from this level on it is as good as the surface.
constexpr int kMeasuredLevel = 2;

void note_point_distances(Work& work, const SurfaceMesh& surface) {
  if (work.points.empty() || surface.level < kMeasuredLevel || work.report.point_distances) return;
  const auto triangles = quads_as_triangles(surface.face_vertices);
  PointDistances distances = measure_distances(work.points, surface.positions, triangles);
  distances.max /= work.fitted.placement.diagonal;
  distances.rms /= work.fitted.placement.diagonal;
  work.report.point_distances = distances;
}

SurfaceMesh evaluate_level(Work& work, int level) {
  EvaluateOptions options;
  options.level = level;
  options.weights = work.job.settings.weights;
  options.sharp = work.job.settings.sharp();
  options.rest_positions = work.input.positions;
  options.callbacks = callbacks_for(work.report, work.context);
  return timed(work.report.timing.evaluate, [&] {
    SurfaceMesh surface = evaluate(work.fitted.cage, work.backend, options);
    note_folds(work.report, surface, work.input, work.context.console);
    note_point_distances(work, surface);
    return surface;
  });
}

void write_one(Work& work, const PlannedOutput& planned, const SurfaceMesh* surface,
               const SurfaceOutputOptions& options, WrittenOutput& written) {
  check_interrupt();
  timed(work.report.timing.write, [&] {
    std::filesystem::path target;
    if (!planned.to_stdout) target = work.staged.stage(planned.path);
    if (planned.format == OutputFormat::Gltf) {
      (void)work.staged.stage(gltf_companion(planned.path));
    }
    written = surface != nullptr
                  ? write_surface_output(planned, target, *surface, options, work.stdout_bytes)
                  : write_cage_output(planned, target, work.fitted.cage, work.report, options.given,
                                      options.diagonal);
  });
  warn_of_rounding(work.report, work.context.console, written);
}

// Cages first; then every level once, whatever the number of files that show it.
void write_outputs(Work& work) {
  const SurfaceOutputOptions common =
      surface_options(work.job, work.report, work.fitted.placement, work.input,
                      callbacks_for(work.report, work.context));
  std::vector<WrittenOutput>& written = work.report.outputs;
  written.resize(work.outputs.size());
  std::vector<int> levels;
  for (std::size_t i = 0; i < work.outputs.size(); ++i) {
    const PlannedOutput& planned = work.outputs[i];
    if (planned.kind == OutputKind::Cage) {
      write_one(work, planned, nullptr, common, written[i]);
    } else if (std::ranges::find(levels, planned.level) == levels.end()) {
      levels.push_back(planned.level);
    }
  }
  for (const int level : levels) {
    const SurfaceMesh surface = evaluate_level(work, level);
    SurfaceOutputOptions options = common;
    options.gltf.extras.emplace_back("level", std::int64_t{level});
    for (std::size_t i = 0; i < work.outputs.size(); ++i) {
      const PlannedOutput& planned = work.outputs[i];
      if (planned.kind == OutputKind::Surface && planned.level == level) {
        write_one(work, planned, &surface, options, written[i]);
      }
    }
  }
  // Folds cannot be seen on the cage or at level 0.
  const bool asks_for_result = !work.outputs.empty() || !work.job.report.empty();
  const bool lacks_distances = !work.points.empty() && !work.report.point_distances;
  if (asks_for_result && lacks_distances) (void)evaluate_level(work, kMeasuredLevel);
  if (asks_for_result && !work.report.folded_area) (void)evaluate_level(work, 1);
}

void write_report(const Job& job, const JobReport& report, StagedFiles& staged) {
  if (job.report.empty() || job.report == "-") return;
  OutputFile file(staged.stage(job.report));
  file.write(json_text(to_json(report)));
  file.commit();
}

}  // namespace

JobReport run_job(const Job& job, const std::vector<PlannedOutput>& outputs, Backend& backend,
                  const JobContext& context) {
  JobReport report;
  report.job = job.name;
  report.arguments = context.arguments;
  report.settings = job.settings;
  report.device = backend.description();
  context.progress.begin_job(job.name);
  StagedFiles staged;
  std::vector<std::byte> stdout_bytes;
  timed(report.timing.total, [&] {
    context.progress.update("read", 0);
    JobInput made = timed(report.timing.read, [&] { return read_job_input(job, report, context); });
    Input& input = made.input;
    timed(report.timing.check, [&] { prepare_input(input, report, context.console); });
    const PolygonMesh& mesh = input.file.mesh;
    Fit result = fit_input(input, backend, report, callbacks_for(report, context));
    report.input.statistics = timed(report.timing.check, [&] { return statistics(mesh); });
    note_fit(report, result);
    warn_of_unused(report, mesh, context.console);
    warn_of_the_solve(report, context.console);
    Work work{job, outputs, backend, context, mesh, made.points, result, report, staged, {}};
    write_outputs(work);
    stdout_bytes = std::move(work.stdout_bytes);
  });
  report.host_peak_bytes = peak_host_bytes();
  report.device_bytes = backend.peak_device_bytes();
  write_report(job, report, staged);
  context.progress.finish();
  check_interrupt();
  if (!stdout_bytes.empty()) {
    write_stdout({reinterpret_cast<const char*>(stdout_bytes.data()), stdout_bytes.size()});
  }
  staged.commit();
  if (job.report == "-") write_stdout(json_text(to_json(report)));
  return report;
}

namespace {

// How large the mesh will be is not known before it is made.
void describe_point_job(const Job& job, const std::vector<PlannedOutput>& outputs,
                        const DeviceDescription& device) {
  const PointInput input = read_point_input(job.input);
  std::string text = "would reconstruct and fit " + input.name + ": " +
                     with_separators(static_cast<std::int64_t>(input.cloud.points.size())) +
                     " points\n";
  text += "  device      " + device.kind + ", " + device.name + "\n";
  for (const PlannedOutput& output : outputs)
    text +=
        "  would write " + (output.to_stdout ? std::string("stdout") : output.path.string()) + "\n";
  if (!job.report.empty()) text += "  would write " + job.report + "  (report)\n";
  write_stdout(text);
}

}  // namespace

void describe_job(const Job& job, const std::vector<PlannedOutput>& outputs,
                  const DeviceDescription& device) {
  if (is_point_path(job.input, job.input_format)) {
    describe_point_job(job, outputs, device);
    return;
  }
  const Input input = read_input(job.input, job.input_format);
  const PolygonMesh mesh = prepare(input.file.mesh, job.settings).mesh;
  require_usable(mesh, input.name);
  std::string text = "would fit " + input.name + ": " + with_separators(mesh.vertex_count()) +
                     " vertices" + ", " + counted(mesh.face_count(), "face") + "\n";
  const Settings& settings = job.settings;
  text += "  device      " + device.kind + ", " + device.name + "\n  solve       " +
          std::string(name_of(settings.solver)) + ", " + std::string(name_of(settings.weights)) +
          " weights, tolerance " + short_number(settings.tolerance) + "\n";
  for (const PlannedOutput& output : outputs) {
    text += "  would write " + (output.to_stdout ? std::string("stdout") : output.path.string());
    if (output.kind == OutputKind::Cage) {
      text += "  (control cage)\n";
      continue;
    }
    const auto corners = static_cast<std::int64_t>(mesh.face_vertices.size());
    text += "  (level " + std::to_string(output.level) + ", " +
            (output.level == 0 ? counted(mesh.face_count(), "face")
                               : counted(corners << (2 * (output.level - 1)), "quad")) +
            ")\n";
  }
  if (!job.report.empty()) text += "  would write " + job.report + "  (report)\n";
  write_stdout(text);
}

}  // namespace planish::command
