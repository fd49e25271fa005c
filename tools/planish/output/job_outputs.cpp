#include "output/job_outputs.h"

#include <algorithm>
#include <optional>

#include "job/job_surface.h"
#include "job/measure_surface.h"
#include "job/timed.h"
#include "output/further_buffers.h"
#include "output/surface_output.h"
#include "page/page_coding.h"
#include "page/page_job.h"
#include "page/page_still.h"
#include "planish/files/formats.h"
#include "planish/files/tiles/write_tiles.h"
#include "planish/pipeline/fit_mesh.h"
#include "terminal/interrupt.h"
#include "terminal/text.h"

namespace planish::command {
namespace {

SurfaceOutputOptions surface_options(const Job& job, const JobReport& report,
                                     const FittedMesh& fitted, const Callbacks& callbacks) {
  SurfaceOutputOptions options;
  options.vertices = fitted.mesh.positions;
  options.given = fitted.points();
  options.gltf.callbacks = callbacks;
  options.diagonal = fitted.fit.placement.diagonal;
  options.tolerance = job.settings.tolerance;
  options.gltf.compression = job.settings.compression;
  const std::string stem =
      job.input == "-" ? job.name : std::filesystem::path(job.input).stem().string();
  options.gltf.name = plain_utf8(stem);
  options.gltf.double_sided = report.input.statistics.boundary_loop_count > 0;
  options.gltf.z_up = job.settings.up == UpAxis::Z;
  options.gltf.origin = storage_origin(fitted.fit.placement);
  options.gltf.extras = fit_extras(fitted.options, fitted.creases(), report.interpolation);
  return options;
}

// A tolerance finer than float32 holds in the solve but not in a glTF file.
void warn_of_rounding(JobReport& report, Console& console, const WrittenOutput& output) {
  const double tolerance = report.settings.tolerance;
  if (!report.interpolation.converged || output.as_written_error <= tolerance) return;
  add_warning(report, console,
              {"rounded-output",
               output_name(output.path) + ": rounding for the file leaves an error of " +
                   short_number(output.as_written_error) + ", above the tolerance " +
                   short_number(tolerance) + "; --cage and .ply keep every digit",
               1, -1});
}

// The origin of the rows of a level where a glTF file shows it.
std::optional<glm::dvec3> stored_about(const FittedJob& work, const Fineness& fineness,
                                       const SurfaceOutputOptions& options) {
  for (const PlannedOutput& planned : work.outputs) {
    if (planned.kind == OutputKind::Surface && planned.fineness == fineness &&
        (planned.to_stdout || info_of(planned.format).is_gltf)) {
      return options.gltf.origin;
    }
  }
  return std::nullopt;
}

JobLevel measured_level(const FittedJob& work, JobSurface& surface, int level,
                        const SurfaceOutputOptions& options) {
  return timed(work.report.timing.evaluate, [&] {
    work.context.progress.update("level", 0);
    JobLevel made = surface.level(level);
    work.context.progress.update("measure", 0);
    measure_surface(work.made, made, stored_about(work, {.level = level}, options), work.report,
                    work.context);
    return made;
  });
}

// Nothing is measured on triangles of all sizes: that is for a level.
JobLevel adaptive_surface(const FittedJob& work, JobSurface& surface, const Fineness& fineness) {
  work.context.progress.update("level", 0);
  return timed(work.report.timing.evaluate, [&] { return surface.adaptive(fineness); });
}

void write_one(const FittedJob& work, const PlannedOutput& planned, JobLevel* surface,
               const SurfaceOutputOptions& options, WrittenOutput& written,
               std::vector<std::byte>& stdout_bytes) {
  check_interrupt();
  work.context.progress.update("write", 0);
  timed(work.report.timing.write, [&] {
    std::filesystem::path target;
    if (!planned.to_stdout) target = work.staged.stage(planned.path);
    written = surface != nullptr
                  ? write_surface_output(planned, target, *surface, options, stdout_bytes)
                  : write_cage_output(planned, target, work.made.fitted, work.report);
    if (planned.to_stdout) return;
    const std::filesystem::path beside = companion_of(target, planned.format);
    if (!beside.empty() && std::filesystem::exists(beside))
      (void)work.staged.stage(companion_of(planned.path, planned.format));
    if (planned.format == FileFormat::Gltf) stage_further_buffers(planned, target, work.staged);
  });
  warn_of_rounding(work.report, work.context.console, written);
}

// Tiles are made level by level as they are written.
void write_tiles_of(const FittedJob& work, const PlannedOutput& planned, JobSurface& all,
                    const SurfaceOutputOptions& options, WrittenOutput& written) {
  check_interrupt();
  work.context.progress.update("write", 0);
  timed(work.report.timing.write, [&] {
    const std::filesystem::path target =
        work.staged.stage_with_folder(planned.path, tile_folder(planned.path));
    written =
        write_tiles_output(planned, target, *all.made_doo_sabin(), work.job.settings, options);
  });
  warn_of_rounding(work.report, work.context.console, written);
}

// The fields that the job wants as data; `fields` holds them.
void add_attributes(const FittedJob& work, const JobSurface& all, JobLevel& surface,
                    VertexFields& fields, GltfOptions& options) {
  const FieldChoice& choice = work.job.settings.attributes;
  if (!choice.any()) return;
  fields = vertex_fields(surface.whole(), work.made.fitted.mesh,
                         work.made.fitted.fit.placement.diagonal, all.doo_sabin());
  options.fields = named_fields(fields, choice);
  if (!choice.curvature) return;
  options.extras.emplace_back("curvature_from", std::string(name_of(fields.curvature_source)));
}

// The scene of the page, of the surface of page_level().
void make_scene(const FittedJob& work, const JobSurface& all, JobLevel& surface) {
  check_interrupt();
  work.context.progress.update("page", 0);
  timed(work.report.timing.write, [&] {
    const Settings& settings = work.job.settings;
    work.page.payloads.clear();
    const PageScene scene =
        job_scene({surface.whole(), work.made.fitted.mesh, work.made.fitted.fit, settings,
                   work.made.fitted.source_vertices, all.doo_sabin()});
    const std::vector<std::byte> still = still_picture(surface.whole(), settings.up);
    work.page.still =
        base64_text({reinterpret_cast<const std::uint8_t*>(still.data()), still.size()});
    surface.let_go();
    work.page.payloads = make_payloads(scene, settings, work.context.page);
  });
}

// The same level by level, for large meshes: a finer one takes long and may not fit.
void make_scene_by_level(const FittedJob& work, JobSurface& all, int deepest) {
  bool may_fit = true;
  for (int level = 0; level <= deepest && may_fit; ++level) {
    JobLevel made = timed(work.report.timing.evaluate, [&] { return all.level(level); });
    const auto rows = static_cast<std::size_t>(made.blocks().info().row_count);
    make_scene(work, all, made);
    may_fit = may_be_finer(work.page.payloads.back(), rows, work.context.page);
  }
}

}  // namespace

std::vector<std::byte> write_outputs(const FittedJob& work) {
  std::vector<std::byte> stdout_bytes;
  const SurfaceOutputOptions common = surface_options(work.job, work.report, work.made.fitted,
                                                      callbacks_for(work.report, work.context));
  std::vector<WrittenOutput>& written = work.report.outputs;
  written.resize(work.outputs.size());
  std::vector<Fineness> finenesses;
  for (std::size_t i = 0; i < work.outputs.size(); ++i) {
    const PlannedOutput& planned = work.outputs[i];
    if (planned.kind == OutputKind::Cage) {
      write_one(work, planned, nullptr, common, written[i], stdout_bytes);
    } else if (!info_of(planned.format).is_tiles &&
               std::ranges::find(finenesses, planned.fineness) == finenesses.end()) {
      finenesses.push_back(planned.fineness);
    }
  }
  JobSurface all(work.made.fitted, work.backend, callbacks_for(work.report, work.context));
  int scene_level =
      work.context.wants_page(work.job)
          ? page_level(work.made.fitted.mesh, work.job.settings.scheme, work.context.page)
          : -1;
  constexpr std::int32_t kLarge = 1 << 15;
  if (scene_level > 0 && work.made.fitted.mesh.vertex_count() >= kLarge) {
    make_scene_by_level(work, all, scene_level);
    scene_level = -1;
  }
  for (const Fineness& fineness : finenesses) {
    JobLevel surface = fineness.is_adaptive() ? adaptive_surface(work, all, fineness)
                                              : measured_level(work, all, fineness.level, common);
    VertexFields fields;
    SurfaceOutputOptions options = common;
    add_attributes(work, all, surface, fields, options.gltf);
    if (!fineness.is_adaptive())
      options.gltf.extras.emplace_back("level", std::int64_t{fineness.level});
    if (fineness.chord_error > 0)
      options.gltf.extras.emplace_back("chord_error", fineness.chord_error);
    if (fineness.angle > 0) options.gltf.extras.emplace_back("angle", fineness.angle);
    for (std::size_t i = 0; i < work.outputs.size(); ++i) {
      const PlannedOutput& planned = work.outputs[i];
      if (planned.kind == OutputKind::Surface && planned.fineness == fineness &&
          !info_of(planned.format).is_tiles) {
        write_one(work, planned, &surface, options, written[i], stdout_bytes);
      }
    }
    if (!fineness.is_adaptive() && fineness.level == scene_level) make_scene(work, all, surface);
  }
  for (std::size_t i = 0; i < work.outputs.size(); ++i) {
    if (info_of(work.outputs[i].format).is_tiles)
      write_tiles_of(work, work.outputs[i], all, common, written[i]);
  }
  // What is seen on the page is what is measured.
  if (scene_level >= 0 && work.page.payloads.empty()) {
    JobLevel surface = measured_level(work, all, scene_level, common);
    make_scene(work, all, surface);
  }
  // What cannot be seen on the cage or at level 0.
  const bool asks_for_result =
      !work.outputs.empty() || !work.job.report.empty() || work.context.wants_page(work.job);
  const bool lacks_distances = !work.made.points.empty() && !work.report.point_distances;
  if (asks_for_result && lacks_distances) {
    if (work.job.settings.scheme == Scheme::DooSabin) {
      timed(work.report.timing.evaluate,
            [&] { measure_points(work.made, all, work.report, work.context); });
    } else {
      (void)measured_level(work, all, kPointDistanceLevel, common);
    }
  }
  if (asks_for_result && !work.report.surface &&
      !note_chosen_surface(work.made, work.report, work.context))
    (void)measured_level(work, all, 1, common);
  if (work.report.surface && work.made.source && work.job.settings.scheme == Scheme::DooSabin) {
    timed(work.report.timing.evaluate,
          [&] { measure_source(work.made, all, work.report, work.context); });
  }
  if (work.report.surface && !work.made.fitted.separated_edges.empty())
    note_sheet_gap(work.made, all.made_doo_sabin(), work.report);
  return stdout_bytes;
}

}  // namespace planish::command
