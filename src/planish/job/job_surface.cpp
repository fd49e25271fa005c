#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include "planish/adaptive/adaptive_blocks.h"
#include "planish/core/words.h"
#include "planish/files/formats.h"
#include "planish/job/job_input.h"
#include "planish/job/job_outputs.h"
#include "planish/job/job_text.h"
#include "planish/measure/figures.h"
#include "planish/measure/vertex_fields.h"
#include "planish/mesh/edge_groups.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/pipeline/asset_attributes.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/pipeline/fit_report.h"
#include "planish/queries/surface_queries.h"
#include "planish/reconstruct/compare_source.h"
#include "planish/reconstruct/point_tree.h"
#include "planish/surface/evaluate.h"
#include "planish/surface/kept_rows.h"

namespace planish {

JobLevel::JobLevel(std::unique_ptr<const SurfaceMesh> whole, const PolygonMesh& mesh)
    : made_whole_(std::move(whole)), blocks_(blocks_of(*made_whole_, mesh)) {}

void JobLevel::keep(const glm::dvec3& origin, QuadVisit visit) {
  kept_ =
      keep_rows(*blocks_, {.origin = origin, .visit = std::move(visit), .callbacks = callbacks_});
}

JobLevel::JobLevel(std::unique_ptr<const AdaptiveSurface> adaptive, const LimitSurface& lies_on,
                   std::optional<DecimationFigures> decimated)
    : adaptive_(std::move(adaptive)),
      decimated_(decimated),
      blocks_(std::make_unique<AdaptiveBlocks>(*adaptive_, lies_on)) {}

const SurfaceMesh& JobLevel::whole() {
  if (adaptive_) return adaptive_->mesh;
  if (made_whole_) return *made_whole_;
  if (!collected_) collected_ = std::make_unique<const SurfaceMesh>(collect(blocks(), callbacks_));
  return *collected_;
}

JobSurface::JobSurface(const FittedMesh& fitted, Backend& backend, Callbacks callbacks)
    : fitted_(fitted), backend_(backend), options_(fitted.evaluate_options()) {
  options_.callbacks = std::move(callbacks);
}

JobLevel JobSurface::level(int level) {
  options_.level = level;
  if (options_.scheme != Scheme::DooSabin) {
    return {std::make_unique<const SurfaceMesh>(
                evaluate(fitted_.mesh, fitted_.fit, backend_, options_)),
            fitted_.mesh};
  }
  (void)made_doo_sabin();
  auto* const evaluator = dynamic_cast<PatchEvaluator*>(&backend_);
  return JobLevel(doo_sabin_->level(level, options_.memory_limit_bytes, evaluator),
                  options_.callbacks);
}

std::shared_ptr<const DooSabinSurface> JobSurface::made_doo_sabin() {
  if (!doo_sabin_ && options_.scheme == Scheme::DooSabin)
    doo_sabin_ = fitted_surface(fitted_.mesh, fitted_.fit, options_);
  return doo_sabin_;
}

const LimitSurface& JobSurface::limit() {
  (void)made_doo_sabin();
  if (!limit_) limit_ = std::make_unique<const LimitSurface>(doo_sabin_);
  return *limit_;
}

JobLevel JobSurface::adaptive(const Fineness& fineness) {
  if (fineness.target.any()) {
    DecimatedSurface made = decimate(limit(), {.target = fineness.target,
                                               .diagonal = fitted_.fit.placement.diagonal,
                                               .callbacks = options_.callbacks});
    return {std::make_unique<const AdaptiveSurface>(std::move(made.surface)), limit(),
            made.figures};
  }
  return {std::make_unique<const AdaptiveSurface>(
              tessellate(limit(), {.chord_error = fineness.chord_error,
                                   .angle = fineness.angle,
                                   .diagonal = fitted_.fit.placement.diagonal,
                                   .callbacks = options_.callbacks})),
          limit()};
}

namespace {

PointDistances relative(PointDistances distances, double diagonal) {
  distances.max /= diagonal;
  distances.rms /= diagonal;
  return distances;
}

std::vector<Triangle> triangles_of(const SurfaceMesh& surface) {
  if (!surface.is_triangles()) return quads_as_triangles(surface.face_vertices);
  std::vector<Triangle> triangles;
  for (std::int64_t f = 0; f < surface.face_count(); ++f) {
    const auto face = surface.face(f);
    triangles.push_back({face[0], face[1], face[2]});
  }
  return triangles;
}

// In the pass that keeps the rows where they are written afterwards.
SurfaceQuality quality_of(const FittedJob& work, JobLevel& surface,
                          const std::optional<glm::dvec3>& stored_about,
                          const Callbacks& callbacks) {
  const PolygonMesh& mesh = work.fitted.mesh;
  if (surface.is_whole()) return surface_quality(surface.whole(), mesh);
  const std::vector<std::uint8_t>& is_beside = work.made.folds.is_beside;
  if (!stored_about) return surface_quality(surface.blocks(), mesh, is_beside, callbacks);
  BlockQuality quality(surface.blocks(), mesh, is_beside);
  surface.keep(*stored_about,
               [&](RowRange faces, std::span<const glm::dvec3> positions,
                   std::span<const glm::vec3> normals) { quality.add(faces, positions, normals); });
  return quality.result();
}

void note_quality(const FittedJob& work, JobLevel& surface,
                  const std::optional<glm::dvec3>& stored_about) {
  const Callbacks callbacks = callbacks_for(work.report, work.context);
  const std::optional<Input>& source = work.made.source;
  MeasuredSurface& measured = work.report.surface.emplace();
  measured.level = surface.level();
  if (!source) {
    measured.quality = quality_of(work, surface, stored_about, callbacks);
    return;
  }
  const SourceComparison comparison =
      compare_with_source(surface.blocks(), source->file.mesh, callbacks);
  measured.quality = comparison.quality;
  measured.reference = source->name;
  measured.source_distances = relative(comparison.distances, work.fitted.fit.placement.diagonal);
}

// By closest points, of neighbours one after another and so many at a time that answers take little
// memory; of the diagonal.
PointDistances distances_from(std::span<const glm::dvec3> points, const LimitSurface& surface,
                              double diagonal, const JobContext& context) {
  constexpr std::size_t kAtOnce = 1 << 14;
  const SurfaceQueries queries(surface);
  const std::vector<std::int32_t> order = spatial_order(points);
  std::vector<double> found;
  std::vector<glm::dvec3> places;
  PointDistances distances;
  double sum = 0;
  for (std::size_t first = 0; first < points.size(); first += kAtOnce) {
    const auto some = std::span(order).subspan(first, std::min(kAtOnce, points.size() - first));
    places.clear();
    for (const std::int32_t point : some) places.push_back(points[point]);
    found.resize(some.size());
    queries.distances(places, found);
    for (std::size_t i = 0; i < found.size(); ++i) {
      const double distance = found[i] / diagonal;
      sum += distance * distance;
      const bool is_first = distance == distances.max && some[i] < distances.farthest;
      if (distances.farthest >= 0 && distance <= distances.max && !is_first) continue;
      distances.max = distance;
      distances.farthest = some[i];
    }
    context.progress.update(
        "measure", static_cast<double>(first + found.size()) / static_cast<double>(points.size()));
  }
  distances.rms = std::sqrt(sum / static_cast<double>(points.size()));
  return distances;
}

void warn_of_folds(const FittedJob& work) {
  JobReport& report = work.report;
  const bool against_source = !report.surface->reference.empty();
  if (const auto folds = fold_warning(work.fitted, report.surface->quality, against_source))
    add_warning(report, work.context, *folds);
}

}  // namespace

void measure_surface(const FittedJob& work, JobLevel& surface,
                     const std::optional<glm::dvec3>& stored_about) {
  JobReport& report = work.report;
  if (surface.level() >= 1 && !report.surface) {
    note_quality(work, surface, stored_about);
    warn_of_folds(work);
  }
  if (report.settings.scheme != Scheme::DooSabin && surface.level() >= kPointDistanceLevel &&
      !work.made.points.empty() && !report.point_distances) {
    const SurfaceMesh& whole = surface.whole();
    report.point_distances =
        relative(measure_distances(work.made.points, whole.positions, triangles_of(whole)),
                 work.fitted.fit.placement.diagonal);
  }
  if (stored_about && !surface.is_whole() && !surface.is_kept()) surface.keep(*stored_about, {});
}

void note_texture_slide(const FittedJob& work, JobSurface& surface) {
  const FittedMesh& fitted = work.fitted;
  if (fitted.mesh.face_uvs.empty()) return;
  JobLevel level = surface.level(kBendingLevel);
  TextureSlide slide =
      texture_slide(level.blocks(), fitted.mesh, callbacks_for(work.report, work.context));
  slide.largest_distance /= fitted.fit.placement.diagonal;
  slide.rms_distance /= fitted.fit.placement.diagonal;
  work.report.surface->texture_slide = slide;
  if (const auto warning = slide_warning(fitted, slide))
    add_warning(work.report, work.context, *warning);
}

void note_sheet_gap(const FittedMesh& fitted, const std::shared_ptr<const DooSabinSurface>& surface,
                    JobReport& report) {
  if (!surface) return;
  report.surface->sheet_gap =
      sheet_gap(LimitSurface(surface), fitted.source_vertices, fitted.separated_edges) /
      fitted.fit.placement.diagonal;
}

void measure_points(const FittedJob& work, JobSurface& surface) {
  work.context.progress.update("distances", 0);
  work.report.point_distances = distances_from(work.made.points, surface.limit(),
                                               work.fitted.fit.placement.diagonal, work.context);
}

void measure_source(const FittedJob& work, JobSurface& surface) {
  work.context.progress.update("distances", 0);
  const UsedMesh source = without_unused_vertices(work.made.source->file.mesh);
  work.report.surface->distances_from_source = distances_from(
      source.mesh.positions, surface.limit(), work.fitted.fit.placement.diagonal, work.context);
}

bool note_chosen_surface(const FittedJob& work) {
  const SurfaceQuality* const measured = work.made.source ? nullptr : work.fitted.chosen_quality();
  if (measured == nullptr) return false;
  MeasuredSurface& surface = work.report.surface.emplace();
  surface.level = 1;
  surface.quality = *measured;
  warn_of_folds(work);
  return true;
}

void note_bending(const FittedJob& work, JobSurface& surface) {
  MeasuredSurface& measured = *work.report.surface;
  if (measured.level == kBendingLevel) return;
  if (const SurfaceQuality* const known = work.fitted.chosen_quality()) {
    measured.quality.bending = known->bending;
    return;
  }
  JobLevel level = surface.level(kBendingLevel);
  measured.quality.bending =
      quality_of(work, level, std::nullopt, callbacks_for(work.report, work.context)).bending;
}

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
  const std::string stem = job.input == "-" ? job.name : utf8(path_of(job.input).stem());
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
  if (surface.decimated()) options.gltf.extras.emplace_back("distance", surface.decimated()->max);
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
