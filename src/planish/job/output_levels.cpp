#include "planish/job/output_levels.h"

#include <algorithm>
#include <optional>

#include "planish/files/formats.h"
#include "planish/job/measure_surface.h"
#include "planish/job/text.h"
#include "planish/job/timed.h"
#include "planish/pipeline/attribute_fields.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/pipeline/mesh_warnings.h"

namespace planish {
namespace {

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

// Nothing is measured on triangles of all sizes: that is for a level.
JobLevel adaptive_surface(const FittedJob& work, JobSurface& surface, const Fineness& fineness) {
  work.context.progress.update("level", 0);
  return timed(work.report.timing.evaluate, [&] { return surface.adaptive(fineness); });
}

// The fields that the job wants as data; `fields` holds them.
void add_attributes(const FittedJob& work, const JobSurface& all, JobLevel& surface,
                    VertexFields& fields, GltfOptions& options) {
  const FieldChoice& choice = work.job.settings.attributes;
  if (!choice.any()) return;
  fields = vertex_fields(surface.whole(), work.fitted.mesh, work.fitted.fit.placement.diagonal,
                         all.doo_sabin());
  options.fields = named_fields(fields, choice);
  if (!choice.curvature) return;
  options.extras.emplace_back("curvature_from", std::string(name_of(fields.curvature_source)));
}

}  // namespace

SurfaceOutputOptions surface_options(const FittedJob& work) {
  const Job& job = work.job;
  const JobReport& report = work.report;
  const FittedMesh& fitted = work.fitted;
  SurfaceOutputOptions options;
  options.vertices = fitted.mesh.positions;
  options.materials = &work.made.materials.library;
  options.given = fitted.points();
  options.gltf.callbacks = callbacks_for(work.report, work.context);
  options.diagonal = fitted.fit.placement.diagonal;
  options.tolerance = job.settings.tolerance;
  options.digests = job.digests;
  options.gltf.compression = job.settings.compression;
  const std::string stem =
      job.input == "-" ? job.name : std::filesystem::path(job.input).stem().string();
  options.gltf.name = plain_utf8(stem);
  options.gltf.double_sided = report.input.statistics.boundary_loop_count > 0;
  options.gltf.materials = &work.made.materials.gltf;
  options.gltf.z_up = job.settings.up == UpAxis::Z;
  options.gltf.origin = storage_origin(fitted.fit.placement);
  options.gltf.extras = fit_extras(fitted.options, fitted.creases(), report.fit.interpolation);
  return options;
}

void warn_of_rounding(JobReport& report, const JobContext& context, const WrittenOutput& output) {
  if (!report.fit.interpolation.converged) return;
  if (const auto rounded = rounding_warning(output_name(output.path), output.as_written_error,
                                            report.settings.tolerance))
    add_warning(report, context, *rounded);
}

void warn_of_size(JobReport& report, std::uint64_t input_bytes, const JobContext& context) {
  for (const WrittenOutput& output : report.outputs) {
    if (!output.fineness.by_density) continue;
    if (const auto large = size_warning(output_name(output.path), output.bytes, input_bytes,
                                        output.fineness.level))
      add_warning(report, context, *large);
  }
}

JobLevel measured_level(const FittedJob& work, JobSurface& surface, int level,
                        const SurfaceOutputOptions& options) {
  return timed(work.report.timing.evaluate, [&] {
    work.context.progress.update("level", 0);
    JobLevel made = surface.level(level);
    if (!work.job.measures) return made;
    work.context.progress.update("measure", 0);
    measure_surface(work, made, stored_about(work, {.level = level}, options));
    return made;
  });
}

JobLevel surface_of(const FittedJob& work, JobSurface& all, const Fineness& fineness,
                    LevelFields& fields, SurfaceOutputOptions& options) {
  JobLevel surface = fineness.is_adaptive() ? adaptive_surface(work, all, fineness)
                                            : measured_level(work, all, fineness.level, options);
  add_attributes(work, all, surface, fields.figures, options.gltf);
  if (std::ranges::any_of(work.outputs, [&](const PlannedOutput& planned) {
        return planned.kind == OutputKind::Surface && planned.fineness == fineness &&
               info_of(planned.format).keeps_fields;
      }))
    fields.attributes =
        add_attributes(surface.blocks(), options.gltf.fields, options.gltf.callbacks);
  if (!fineness.is_adaptive())
    options.gltf.extras.emplace_back("level", std::int64_t{fineness.level});
  if (fineness.chord_error > 0)
    options.gltf.extras.emplace_back("chord_error", fineness.chord_error);
  if (fineness.angle > 0) options.gltf.extras.emplace_back("angle", fineness.angle);
  return surface;
}

std::vector<Fineness> finenesses_of(const std::vector<PlannedOutput>& outputs) {
  std::vector<Fineness> finenesses;
  for (const PlannedOutput& planned : outputs) {
    if (planned.kind == OutputKind::Surface && info_of(planned.format).has_fineness() &&
        planned.coarser.empty() &&
        std::ranges::find(finenesses, planned.fineness) == finenesses.end())
      finenesses.push_back(planned.fineness);
  }
  return finenesses;
}

}  // namespace planish
