#include "job_outputs.h"

#include <algorithm>
#include <cmath>

#include "interrupt.h"
#include "job_input.h"
#include "planish/core/version.h"
#include "planish/reconstruct/triangle_edges.h"
#include "planish/surface/evaluate.h"
#include "planish/surface/folded_area.h"
#include "surface_output.h"
#include "text.h"
#include "timed.h"

namespace planish::command {
namespace {

/// A surface whose folded part is larger than this fraction of its area gets a warning.
constexpr double kFoldedAreaLimit = 1e-4;
/// Models farther from the origin than this many diagonals lose digits as float32, so they are
/// stored about their centre.
constexpr double kFarFromOrigin = 10.0;

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

// Distances are measured on a tessellation: from this level on it is as good as the surface.
constexpr int kMeasuredLevel = 2;

void note_point_distances(const FittedJob& work, const SurfaceMesh& surface) {
  if (work.points.empty() || surface.level < kMeasuredLevel || work.report.point_distances) return;
  const auto triangles = quads_as_triangles(surface.face_vertices);
  PointDistances distances = measure_distances(work.points, surface.positions, triangles);
  distances.max /= work.fitted.placement.diagonal;
  distances.rms /= work.fitted.placement.diagonal;
  work.report.point_distances = distances;
}

SurfaceMesh evaluate_level(const FittedJob& work, int level) {
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

void write_one(const FittedJob& work, const PlannedOutput& planned, const SurfaceMesh* surface,
               const SurfaceOutputOptions& options, WrittenOutput& written,
               std::vector<std::byte>& stdout_bytes) {
  check_interrupt();
  timed(work.report.timing.write, [&] {
    std::filesystem::path target;
    if (!planned.to_stdout) target = work.staged.stage(planned.path);
    if (planned.format == OutputFormat::Gltf) {
      (void)work.staged.stage(gltf_companion(planned.path));
    }
    written = surface != nullptr
                  ? write_surface_output(planned, target, *surface, options, stdout_bytes)
                  : write_cage_output(planned, target, work.fitted.cage, work.report, options.given,
                                      options.diagonal);
  });
  warn_of_rounding(work.report, work.context.console, written);
}

}  // namespace

std::vector<std::byte> write_outputs(const FittedJob& work) {
  std::vector<std::byte> stdout_bytes;
  const SurfaceOutputOptions common =
      surface_options(work.job, work.report, work.fitted.placement, work.input,
                      callbacks_for(work.report, work.context));
  std::vector<WrittenOutput>& written = work.report.outputs;
  written.resize(work.outputs.size());
  std::vector<int> levels;
  for (std::size_t i = 0; i < work.outputs.size(); ++i) {
    const PlannedOutput& planned = work.outputs[i];
    if (planned.kind == OutputKind::Cage) {
      write_one(work, planned, nullptr, common, written[i], stdout_bytes);
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
        write_one(work, planned, &surface, options, written[i], stdout_bytes);
      }
    }
  }
  // Folds cannot be seen on the cage or at level 0.
  const bool asks_for_result = !work.outputs.empty() || !work.job.report.empty();
  const bool lacks_distances = !work.points.empty() && !work.report.point_distances;
  if (asks_for_result && lacks_distances) (void)evaluate_level(work, kMeasuredLevel);
  if (asks_for_result && !work.report.folded_area) (void)evaluate_level(work, 1);
  return stdout_bytes;
}

}  // namespace planish::command
