#include "job/job_input.h"

#include <algorithm>
#include <utility>

#include "job/point_input.h"
#include "job/prepare.h"
#include "planish/core/error.h"
#include "planish/mesh/check.h"
#include "terminal/interrupt.h"

namespace planish::command {

void add_warning(JobReport& report, Console& console, const Warning& warning) {
  const auto same = [&](const Warning& other) {
    return other.code == warning.code && other.message == warning.message;
  };
  // Every level of a surface meets the same places.
  if (std::ranges::any_of(report.warnings, same)) return;
  report.warnings.push_back(warning);
  console.warning(warning.message);
}

Callbacks callbacks_for(JobReport& report, const JobContext& context) {
  Callbacks callbacks;
  callbacks.progress = [&context](std::string_view step, double fraction) {
    context.progress.update(step, fraction);
  };
  callbacks.cancelled = [] { return interrupt_signal() != 0; };
  callbacks.warning = [&report, &context](const Warning& warning) {
    add_warning(report, context.console, warning);
  };
  return callbacks;
}

namespace {

// The mesh of the file gives way to points of its surface.
PointInput sample_input(const Job& job, const Callbacks& callbacks) {
  (void)require_mesher();  // before the work
  const Input mesh = read_input(job.input, job.input_format);
  require_usable(mesh.file.mesh, mesh.name);
  return {.name = mesh.name,
          .cloud = sample_surface(mesh, *job.sampling, callbacks),
          .sha256 = mesh.sha256};
}

void reconstruct_points(const PointInput& cloud, JobInput& made, JobReport& report,
                        const Callbacks& callbacks) {
  ReconstructOptions options = report.settings.points;
  options.callbacks = callbacks;
  if (report.settings.scheme == Scheme::Loop) options.pair_quads = false;  // triangles only
  Reconstruction result = reconstruct_input(cloud, options);
  report.reconstruction = reconstruction_json(cloud, result);
  report.reconstruction_summary = reconstruction_summary(cloud, result);
  for (const std::int32_t point : result.used_points)
    made.points.push_back(cloud.cloud.origin + cloud.cloud.points[point]);
  made.input.file.mesh = std::move(result.mesh);
}

Input read_source(const std::string& path) {
  Input source = read_input(path, std::nullopt);
  if (source.file.mesh.face_count() == 0) {
    throw Error(ErrorCode::UnusableMesh,
                source.name + ": a source has to be a mesh, and this has no faces");
  }
  return source;
}

// Auto: points are meshed unevenly, which folds progressive surfaces; a mesh is taken as the paper
// takes it. Other schemes than Doo-Sabin have no fair method.
InterpolationMethod method_for(const Settings& settings, const JobInput& made) {
  const bool fair = settings.interpolation == InterpolationChoice::Fair ||
                    (settings.interpolation == InterpolationChoice::Auto && !made.points.empty() &&
                     settings.scheme == Scheme::DooSabin);
  return fair ? InterpolationMethod::Fair : InterpolationMethod::Progressive;
}

}  // namespace

JobInput read_job_input(const Job& job, JobReport& report, const JobContext& context) {
  Console& console = context.console;
  JobInput made;
  Input& input = made.input;
  if (job.sampling) {
    const Callbacks callbacks = callbacks_for(report, context);
    const PointInput cloud = sample_input(job, callbacks);
    input.name = cloud.name;
    input.sha256 = cloud.sha256;
    report.input.format = name_of(input_format_of(job.input, job.input_format));
    reconstruct_points(cloud, made, report, callbacks);
    report.reconstruction["sampled"] = sampling_json(*job.sampling);
  } else if (is_point_path(job.input, job.input_format)) {
    const PointInput cloud = read_point_input(job.input);
    input.name = cloud.name;
    input.sha256 = cloud.sha256;
    report.input.format = name_of(cloud.format);
    reconstruct_points(cloud, made, report, callbacks_for(report, context));
  } else {
    input = read_input(job.input, job.input_format);
    report.input.format = name_of(input.file.format);
    if (const auto cloud = points_of(input))
      reconstruct_points(*cloud, made, report, callbacks_for(report, context));
  }
  if (!job.source.empty()) made.source = read_source(job.source);
  for (const Warning& warning : input.file.warnings) add_warning(report, console, warning);
  report.input.path = job.input;
  report.input.sha256 = input.sha256;
  report.input.welded = input.file.welded_vertex_count;
  report.input.dropped = input.file.dropped_element_count;
  return made;
}

void prepare_input(JobInput& made, JobReport& report, Console& console) {
  Input& input = made.input;
  report.method = method_for(report.settings, made);
  try {
    ReadyMesh prepared = prepare(std::move(input.file.mesh), report.settings, report.method);
    for (Warning change : prepared.changes) {
      change.message = input.name + ": " + change.message;
      add_warning(report, console, change);
    }
    report.input.changed_faces = std::move(prepared.changed_faces);
    made.file_vertices = std::move(prepared.source_vertices);
    input.file.mesh = std::move(prepared.mesh);
    made.prepared = std::move(prepared.prepared);
  } catch (const Error& error) {
    if (error.code() == ErrorCode::UnusableMesh) require_usable(input.file.mesh, input.name);
    throw;
  }
}

}  // namespace planish::command
