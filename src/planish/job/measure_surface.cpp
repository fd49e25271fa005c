#include "planish/job/measure_surface.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "planish/limit/sheet_gap.h"
#include "planish/limit/surface_queries.h"
#include "planish/mesh/triangle_edges.h"
#include "planish/mesh/used_vertices.h"
#include "planish/pipeline/mesh_warnings.h"
#include "planish/reconstruct/compare_source.h"
#include "planish/reconstruct/spatial_order.h"
#include "planish/surface/block_quality.h"
#include "planish/surface/kept_rows.h"
#include "planish/surface/texture_slide.h"

namespace planish {
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

}  // namespace planish
