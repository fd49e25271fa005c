#include "job/job_input.h"

#include <algorithm>
#include <utility>

#include "job/point_input.h"
#include "job/prepare.h"
#include "job/torn_vertices.h"
#include "options/point_settings.h"
#include "planish/core/error.h"
#include "planish/files/formats.h"
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
  // Of several inputs nobody knows otherwise whose it is.
  const std::string name = report.job + ": ";
  console.warning(warning.message.starts_with(report.input.path) ? warning.message
                                                                 : name + warning.message);
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
PointInput sample_input(const InputFile& file, const Sampling& sampling,
                        const Callbacks& callbacks) {
  (void)require_mesher();  // before the work
  const Input mesh = mesh_of(file);
  require_usable(mesh.file.mesh, mesh.name);
  return {
      .name = mesh.name, .cloud = sample_surface(mesh, sampling, callbacks), .sha256 = mesh.sha256};
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

// Auto: points are meshed unevenly, which folds progressive surfaces. Of a mesh it starts with the
// progressive one. Other schemes than Doo-Sabin have no fair method.
InterpolationMethod method_for(const Settings& settings, const JobInput& made) {
  const bool fair = settings.interpolation == InterpolationChoice::Fair ||
                    (settings.interpolation == InterpolationChoice::Auto && !made.points.empty() &&
                     settings.scheme == Scheme::DooSabin);
  return fair ? InterpolationMethod::Fair : InterpolationMethod::Progressive;
}

bool is_left_open(const Settings& settings) {
  return settings.interpolation == InterpolationChoice::Auto && settings.scheme == Scheme::DooSabin;
}

void note_preparation(JobInput& made, ReadyMesh& ready, JobReport& report, Console& console) {
  for (Warning change : ready.changes) {
    change.message = made.input.name + ": " + change.message;
    add_warning(report, console, change);
  }
  report.input.changed_faces = std::move(ready.changed_faces);
  report.input.welded = made.input.file.welded_vertex_count + ready.welded_count;
  report.input.separated_edges = std::ssize(ready.separated_edges);
  made.separated_edges = std::move(ready.separated_edges);
  made.found = std::move(ready.found);
  made.file_vertices = std::move(ready.source_vertices);
  made.file_faces = std::move(ready.source_faces);
  made.prepared = std::move(ready.prepared);
}

// Whoever has welded, or had sheets separated, knows of vertices at one place.
void warn_of_torn_vertices(const JobInput& made, JobReport& report, Console& console) {
  if (!made.prepared || !made.prepared->uses_all() || report.settings.weld ||
      !made.separated_edges.empty())
    return;
  const TornVertices torn = torn_vertices(made.input.file.mesh, *made.prepared->topology);
  if (torn.count == 0) return;
  const auto first = static_cast<std::size_t>(torn.first);
  add_warning(report, console,
              {"torn-vertices", made.input.name + ": " + torn_text(torn), torn.count,
               made.file_vertices.empty() ? torn.first : made.file_vertices[first]});
}

}  // namespace

JobInput read_job_input(const Job& job, JobReport& report, const JobContext& context) {
  Console& console = context.console;
  JobInput made;
  Input& input = made.input;
  const Callbacks callbacks = callbacks_for(report, context);
  InputFile file = load_input(job.input, job.input_format);
  file.split_normals_crease = report.settings.creases.split_normals;
  input.name = file.name;
  report.input.format = name_of(file.format);
  if (job.sampling) {
    reconstruct_points(sample_input(file, *job.sampling, callbacks), made, report, callbacks);
    report.reconstruction["sampled"] = sampling_json(*job.sampling);
  } else if (holds_points_only(file.format)) {
    reconstruct_points(points_of(file), made, report, callbacks);
  } else {
    input = mesh_of(file);
    report.input.format = name_of(input.file.format);
    if (const auto cloud = points_of(input)) reconstruct_points(*cloud, made, report, callbacks);
  }
  if (file.split_normals_crease && input.file.mesh.creases.empty())
    add_warning(report, console,
                {"no-split-normals",
                 file.name + ": --creases normals found no edge where normals are split"});
  if (!job.source.empty()) made.source = read_source(job.source);
  for (const Warning& warning : input.file.warnings) add_warning(report, console, warning);
  report.input.sha256 = file.sha256();
  report.input.dropped = input.file.dropped_element_count;
  report.input.file_vertices = input.file.mesh.vertex_count();
  report.input.file_faces = input.file.mesh.face_count();
  return made;
}

bool chooses_by_measurement(const Settings& settings, const std::vector<PlannedOutput>& outputs) {
  return is_left_open(settings) && std::ranges::none_of(outputs, [](const PlannedOutput& output) {
           return output.kind == OutputKind::Cage;
         });
}

void prepare_input(JobInput& made, const std::vector<PlannedOutput>& outputs, JobReport& report,
                   Console& console) {
  Input& input = made.input;
  if (!made.points.empty()) report.settings.weld.reset();  // the mesh is our own
  report.method = method_for(report.settings, made);
  if (made.points.empty() && is_left_open(report.settings)) {
    report.choice.emplace().reason =
        "progressive: the control cage keeps the input's faces, as that of --interpolation fair "
        "does not";
    if (chooses_by_measurement(report.settings, outputs)) made.unprepared = input.file.mesh;
  }
  try {
    ReadyMesh ready = prepare(std::move(input.file.mesh), report.settings, report.method);
    note_preparation(made, ready, report, console);
    input.file.mesh = std::move(ready.mesh);
    if (made.points.empty()) warn_of_torn_vertices(made, report, console);
  } catch (const Error& error) {
    if (error.code() == ErrorCode::UnusableMesh) require_usable(input.file.mesh, input.name);
    throw;
  }
}

void take_fair_mesh(JobInput& made, PolygonMesh&& mesh, ReadyMesh&& ready, JobReport& report,
                    Console& console) {
  report.method = InterpolationMethod::Fair;
  note_preparation(made, ready, report, console);
  made.input.file.mesh = std::move(mesh);
}

void warn_of_unused_settings(const Job& job, const JobInput& made, JobReport& report,
                             Console& console) {
  const bool is_fair = report.method == InterpolationMethod::Fair;
  const bool has_tiles = std::ranges::any_of(job.outputs, [](const OutputRequest& output) {
    const auto format = format_of(output.path);
    return format && info_of(*format).is_tiles;
  });
  std::string unused;
  std::int64_t count = 0;
  bool lacks_tiles = false;
  const auto note = [&](std::string_view name) {
    unused += (unused.empty() ? "" : ", ") + flag_of(name);
    ++count;
  };
  for (const std::string& name : job.given_settings) {
    const auto of_points = std::ranges::find(point_settings(), name, &PointSetting::name);
    const bool without_points =
        made.points.empty() ? of_points != point_settings().end() : name == "weld";
    const bool without_steps =
        is_fair && (name == "solver" || name == "max_iterations" || name == "precision");
    const bool without_tiles = !has_tiles && (name == "tile_vertices" || name == "skirts");
    lacks_tiles |= without_tiles;
    if (without_points || without_steps || without_tiles || (!is_fair && name == "polish"))
      note(name);
  }
  if (count == 0) return;
  add_warning(
      report, console,
      {"unused-settings",
       made.input.name + ": without effect here: " + unused + " (the input is " +
           (made.points.empty() ? "a mesh" : "of points") + ", the method " +
           std::string(name_of(report.method)) + (lacks_tiles ? ", no output 3D Tiles" : "") + ")",
       count, -1});
}

}  // namespace planish::command
