#include "job/measure_surface.h"

#include "planish/mesh/folded_edges.h"
#include "planish/reconstruct/compare_source.h"
#include "planish/reconstruct/triangle_edges.h"
#include "planish/surface/block_quality.h"
#include "planish/surface/kept_rows.h"
#include "terminal/text.h"

namespace planish::command {
namespace {

/// A surface whose folded part is larger than this fraction of its area gets a warning.
constexpr double kFoldedAreaLimit = 1e-4;

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

// In the pass that keeps the rows where they are written afterwards, or are few.
SurfaceQuality quality_of(const JobInput& made, JobLevel& surface,
                          const std::optional<glm::dvec3>& stored_about,
                          const Callbacks& callbacks) {
  const PolygonMesh& mesh = made.input.file.mesh;
  if (surface.is_whole()) return surface_quality(surface.whole(), mesh);
  const auto is_beside = folded_edges(mesh, *made.prepared->topology).is_beside;
  if (!stored_about && surface.level() > 1)
    return surface_quality(surface.blocks(), mesh, is_beside, callbacks);
  BlockQuality quality(surface.blocks(), mesh, is_beside);
  surface.keep(stored_about.value_or(glm::dvec3(0.0)), stored_about.has_value(),
               [&](RowRange faces, std::span<const glm::dvec3> positions,
                   std::span<const glm::vec3> normals) { quality.add(faces, positions, normals); });
  return quality.result();
}

void note_quality(const JobInput& made, const Fit& fitted, JobLevel& surface,
                  const std::optional<glm::dvec3>& stored_about, JobReport& report,
                  const Callbacks& callbacks) {
  MeasuredSurface& measured = report.surface.emplace();
  measured.level = surface.level();
  if (!made.source) {
    measured.quality = quality_of(made, surface, stored_about, callbacks);
    return;
  }
  const SourceComparison comparison = compare_with_source(surface.whole(), made.source->file.mesh);
  measured.quality = comparison.quality;
  measured.reference = made.source->name;
  measured.source_distances = relative(comparison.distances, fitted.placement.diagonal);
}

void warn_of_folds(JobReport& report, Console& console) {
  const double folded = report.surface->quality.folded_area;
  if (folded <= kFoldedAreaLimit) return;
  const bool is_fair = report.method == InterpolationMethod::Fair;
  add_warning(report, console,
              {"folded-area",
               short_number(folded * 100) +
                   " % of the surface is folded (turned by more than 90 degrees from " +
                   (report.surface->reference.empty() ? "its face" : "the source") + "); " +
                   (is_fair ? "the input itself is folded or sharp there, --creases auto may help"
                    : report.settings.scheme == Scheme::DooSabin
                        ? "--interpolation fair is made for such meshes"
                        : "--scheme doo-sabin --interpolation fair is made for such meshes"),
               1, -1});
}

}  // namespace

void measure_surface(const JobInput& made, const Fit& fitted, JobLevel& surface,
                     const std::optional<glm::dvec3>& stored_about, JobReport& report,
                     const JobContext& context) {
  if (surface.level() >= 1 && !report.surface) {
    note_quality(made, fitted, surface, stored_about, report, callbacks_for(report, context));
    warn_of_folds(report, context.console);
  }
  if (surface.level() >= kPointDistanceLevel && !made.points.empty() && !report.point_distances) {
    const SurfaceMesh& whole = surface.whole();
    report.point_distances =
        relative(measure_distances(made.points, whole.positions, triangles_of(whole)),
                 fitted.placement.diagonal);
  }
  if (stored_about && !surface.is_whole() && !surface.is_kept())
    surface.keep(*stored_about, true, {});
}

}  // namespace planish::command
