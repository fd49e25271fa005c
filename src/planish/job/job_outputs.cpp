#include "planish/job/job_outputs.h"
#include "planish/core/stop.h"

#include "planish/files/formats.h"
#include "planish/files/tiles/write_tiles.h"
#include "planish/job/baked_maps.h"
#include "planish/job/further_buffers.h"
#include "planish/job/job_surface.h"
#include "planish/job/measure_surface.h"
#include "planish/job/output_levels.h"
#include "planish/job/page/job_page.h"
#include "planish/job/step_output.h"
#include "planish/job/surface_output.h"
#include "planish/job/text.h"
#include "planish/job/timed.h"
#include "planish/pipeline/fit_mesh.h"

namespace planish {
namespace {

// What `make` returns, which writes or draws: a step of the job.
template <class Make>
auto written_step(const FittedJob& work, std::string_view step, const Make& make) {
  check_stop();
  work.context.progress.update(step, 0);
  return timed(work.report.timing.write, make);
}

void write_one(const FittedJob& work, const PlannedOutput& planned, JobLevel* surface,
               const SurfaceOutputOptions& options, WrittenOutput& written,
               std::vector<std::byte>& stdout_bytes) {
  written_step(work, "write", [&] {
    std::filesystem::path target;
    if (!planned.to_stdout) target = work.staged.stage(planned.path);
    written =
        surface != nullptr
            ? write_surface_output(planned, target, *surface, options, stdout_bytes)
            : write_cage_output(planned, target, work.made.cage ? *work.made.cage : work.fitted,
                                work.made.materials.library, work.report, work.job.digests);
    if (planned.to_stdout) return;
    const std::filesystem::path beside = companion_of(target, planned.format);
    if (!beside.empty() && std::filesystem::exists(beside))
      (void)work.staged.stage(companion_of(planned.path, planned.format));
    if (planned.format == FileFormat::Gltf) stage_further_buffers(planned, target, work.staged);
  });
  warn_of_rounding(work.report, work.context, written);
}

// Tiles are made level by level as they are written.
void write_tiles_of(const FittedJob& work, const PlannedOutput& planned, JobSurface& all,
                    const SurfaceOutputOptions& options, WrittenOutput& written) {
  written_step(work, "write", [&] {
    const std::filesystem::path target =
        work.staged.stage_with_folder(planned.path, tile_folder(planned.path));
    written =
        write_tiles_output(planned, target, *all.made_doo_sabin(), work.job.settings, options);
  });
  warn_of_rounding(work.report, work.context, written);
}

// Faces are made as a whole.
void write_step_of(const FittedJob& work, const PlannedOutput& planned, JobSurface& all,
                   const SurfaceOutputOptions& options, WrittenOutput& written) {
  written_step(work, "faces", [&] {
    StepSettings settings = work.job.settings.step;
    settings.unit = settled_unit(settings.unit, work.report.input.format);
    const LimitSurface* const limit =
        work.job.settings.scheme == Scheme::DooSabin ? &all.limit() : nullptr;
    written = write_step_output(planned, work.staged.stage(planned.path), limit, work.fitted,
                                settings, options);
  });
  if (!written.step->is_as_asked()) work.report.falls_short = true;
  warn_of_rounding(work.report, work.context, written);
}

// The deepest level that the page may show; -1: none.
int page_level_of(const FittedJob& work) {
  if (!work.context.wants_page()) return -1;
  return work.context.page->level(work.fitted.mesh, work.job.settings.scheme);
}

// Whether the page can show a finer level.
bool show_on_page(const FittedJob& work, std::size_t mesh, const JobSurface& all,
                  JobLevel& surface) {
  return written_step(work, "page", [&] {
    return work.context.page->show(mesh, surface, work.fitted, work.job.settings, all.doo_sabin());
  });
}

// Of large meshes a finer level takes long and may not fit: these are shown level by level.
bool is_shown_by_level(const FittedJob& work) {
  constexpr std::int32_t kLarge = 1 << 15;
  return work.fitted.mesh.vertex_count() >= kLarge;
}

}  // namespace

void show_mesh(const FittedJob& work, std::size_t mesh, JobSurface& all) {
  const int deepest = page_level_of(work);
  bool may_fit = true;
  for (int level = is_shown_by_level(work) ? 0 : deepest; 0 <= level && level <= deepest && may_fit;
       ++level) {
    JobLevel made = timed(work.report.timing.evaluate, [&] { return all.level(level); });
    may_fit = show_on_page(work, mesh, all, made);
  }
}

void measure_rest(const FittedJob& work, JobSurface& all, const SurfaceOutputOptions& common) {
  if (!work.job.measures) return;
  // What cannot be seen on the cage or at level 0.
  const bool asks_for_result =
      !work.outputs.empty() || !work.job.report.empty() || work.context.wants_page();
  const bool lacks_distances = !work.made.points.empty() && !work.report.point_distances;
  if (asks_for_result && lacks_distances) {
    if (work.job.settings.scheme == Scheme::DooSabin) {
      timed(work.report.timing.evaluate, [&] { measure_points(work, all); });
    } else {
      (void)measured_level(work, all, kPointDistanceLevel, common);
    }
  }
  if (asks_for_result && !work.report.surface && !note_chosen_surface(work))
    (void)measured_level(work, all, 1, common);
  if (work.report.surface && work.made.source && work.job.settings.scheme == Scheme::DooSabin) {
    timed(work.report.timing.evaluate, [&] { measure_source(work, all); });
  }
  const bool shows_bending = !work.job.report.empty() || work.context.wants_page();
  if (work.report.surface && shows_bending) {
    timed(work.report.timing.evaluate, [&] { note_bending(work, all); });
    timed(work.report.timing.evaluate, [&] { note_texture_slide(work, all); });
  }
  if (work.report.surface && !work.fitted.separated_edges.empty())
    note_sheet_gap(work.fitted, all.made_doo_sabin(), work.report);
}

std::vector<std::byte> write_outputs(const FittedJob& work) {
  std::vector<std::byte> stdout_bytes;
  const SurfaceOutputOptions common = surface_options(work);
  std::vector<WrittenOutput>& written = work.report.outputs;
  written.resize(work.outputs.size());
  for (std::size_t i = 0; i < work.outputs.size(); ++i)
    if (work.outputs[i].kind == OutputKind::Cage)
      write_one(work, work.outputs[i], nullptr, common, written[i], stdout_bytes);
  JobSurface all(work.fitted, work.backend, callbacks_for(work.report, work.context));
  int page_level = page_level_of(work);
  if (page_level > 0 && is_shown_by_level(work)) {
    show_mesh(work, 0, all);
    page_level = -1;
  }
  for (const Fineness& fineness : finenesses_of(work.outputs)) {
    SurfaceOutputOptions options = common;
    LevelFields fields;
    JobLevel surface = surface_of(work, all, fineness, fields, options);
    const auto baked = baked_surface(work, all, surface, options.gltf);
    if (baked) baked->add_to(options.gltf);
    for (std::size_t i = 0; i < work.outputs.size(); ++i) {
      const PlannedOutput& planned = work.outputs[i];
      if (planned.kind == OutputKind::Surface && planned.fineness == fineness &&
          info_of(planned.format).has_fineness()) {
        write_one(work, planned, &surface, options, written[i], stdout_bytes);
        if (baked) note_maps(baked->maps(), {}, work.job.settings.bake, written[i]);
      }
    }
    if (!fineness.is_adaptive() && fineness.level == page_level) {
      (void)show_on_page(work, 0, all, surface);
      page_level = -1;
    }
  }
  for (std::size_t i = 0; i < work.outputs.size(); ++i) {
    if (info_of(work.outputs[i].format).is_tiles)
      write_tiles_of(work, work.outputs[i], all, common, written[i]);
  }
  for (std::size_t i = 0; i < work.outputs.size(); ++i) {
    if (info_of(work.outputs[i].format).is_brep)
      write_step_of(work, work.outputs[i], all, common, written[i]);
  }
  // What is seen on the page is what is measured.
  if (page_level >= 0) {
    JobLevel surface = measured_level(work, all, page_level, common);
    (void)show_on_page(work, 0, all, surface);
  }
  measure_rest(work, all, common);
  return stdout_bytes;
}

}  // namespace planish
