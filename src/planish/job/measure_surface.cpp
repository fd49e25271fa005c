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
SurfaceQuality quality_of(const JobInput& made, JobLevel& surface,
                          const std::optional<glm::dvec3>& stored_about,
                          const Callbacks& callbacks) {
  const PolygonMesh& mesh = made.fitted.mesh;
  if (surface.is_whole()) return surface_quality(surface.whole(), mesh);
  const std::vector<std::uint8_t>& is_beside = made.folds.is_beside;
  if (!stored_about) return surface_quality(surface.blocks(), mesh, is_beside, callbacks);
  BlockQuality quality(surface.blocks(), mesh, is_beside);
  surface.keep(*stored_about,
               [&](RowRange faces, std::span<const glm::dvec3> positions,
                   std::span<const glm::vec3> normals) { quality.add(faces, positions, normals); });
  return quality.result();
}

void note_quality(const JobInput& made, JobLevel& surface,
                  const std::optional<glm::dvec3>& stored_about, JobReport& report,
                  const Callbacks& callbacks) {
  MeasuredSurface& measured = report.surface.emplace();
  measured.level = surface.level();
  if (!made.source) {
    measured.quality = quality_of(made, surface, stored_about, callbacks);
    return;
  }
  const SourceComparison comparison =
      compare_with_source(surface.blocks(), made.source->file.mesh, callbacks);
  measured.quality = comparison.quality;
  measured.reference = made.source->name;
  measured.source_distances = relative(comparison.distances, made.fitted.fit.placement.diagonal);
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

void warn_of_folds(const JobInput& made, JobReport& report, const JobContext& context) {
  const bool against_source = !report.surface->reference.empty();
  if (const auto folds = fold_warning(made.fitted, report.surface->quality, against_source))
    add_warning(report, context, *folds);
}

}  // namespace

void measure_surface(const JobInput& made, JobLevel& surface,
                     const std::optional<glm::dvec3>& stored_about, JobReport& report,
                     const JobContext& context) {
  if (surface.level() >= 1 && !report.surface) {
    note_quality(made, surface, stored_about, report, callbacks_for(report, context));
    warn_of_folds(made, report, context);
  }
  if (report.settings.scheme != Scheme::DooSabin && surface.level() >= kPointDistanceLevel &&
      !made.points.empty() && !report.point_distances) {
    const SurfaceMesh& whole = surface.whole();
    report.point_distances =
        relative(measure_distances(made.points, whole.positions, triangles_of(whole)),
                 made.fitted.fit.placement.diagonal);
  }
  if (stored_about && !surface.is_whole() && !surface.is_kept()) surface.keep(*stored_about, {});
}

void note_texture_slide(const JobInput& made, JobSurface& surface, JobReport& report,
                        const JobContext& context) {
  const FittedMesh& fitted = made.fitted;
  if (fitted.mesh.face_uvs.empty()) return;
  JobLevel level = surface.level(kBendingLevel);
  TextureSlide slide = texture_slide(level.blocks(), fitted.mesh, callbacks_for(report, context));
  slide.largest_distance /= fitted.fit.placement.diagonal;
  slide.rms_distance /= fitted.fit.placement.diagonal;
  report.surface->texture_slide = slide;
  if (const auto warning = slide_warning(fitted, slide)) add_warning(report, context, *warning);
}

void note_sheet_gap(const JobInput& made, const std::shared_ptr<const DooSabinSurface>& surface,
                    JobReport& report) {
  if (!surface || !report.surface) return;
  report.surface->sheet_gap =
      sheet_gap(LimitSurface(surface), made.fitted.source_vertices, made.fitted.separated_edges) /
      made.fitted.fit.placement.diagonal;
}

void measure_points(const JobInput& made, JobSurface& surface, JobReport& report,
                    const JobContext& context) {
  context.progress.update("distances", 0);
  report.point_distances =
      distances_from(made.points, surface.limit(), made.fitted.fit.placement.diagonal, context);
}

void measure_source(const JobInput& made, JobSurface& surface, JobReport& report,
                    const JobContext& context) {
  context.progress.update("distances", 0);
  const UsedMesh source = without_unused_vertices(made.source->file.mesh);
  report.surface->distances_from_source = distances_from(
      source.mesh.positions, surface.limit(), made.fitted.fit.placement.diagonal, context);
}

bool note_chosen_surface(const JobInput& made, JobReport& report, const JobContext& context) {
  const SurfaceQuality* const measured = made.source ? nullptr : made.fitted.chosen_quality();
  if (measured == nullptr) return false;
  MeasuredSurface& surface = report.surface.emplace();
  surface.level = 1;
  surface.quality = *measured;
  warn_of_folds(made, report, context);
  return true;
}

void note_bending(const JobInput& made, JobSurface& surface, JobReport& report,
                  const JobContext& context) {
  MeasuredSurface& measured = *report.surface;
  if (measured.level == kBendingLevel) return;
  if (const SurfaceQuality* const known = made.fitted.chosen_quality()) {
    measured.quality.bending = known->bending;
    return;
  }
  JobLevel level = surface.level(kBendingLevel);
  measured.quality.bending =
      quality_of(made, level, std::nullopt, callbacks_for(report, context)).bending;
}

}  // namespace planish
