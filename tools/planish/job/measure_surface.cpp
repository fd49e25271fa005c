#include "job/measure_surface.h"

#include "planish/mesh/folded_edges.h"
#include "planish/reconstruct/compare_source.h"
#include "planish/reconstruct/triangle_edges.h"
#include "planish/surface/block_quality.h"
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

void note_quality(const JobInput& made, const Fit& fitted, JobLevel& surface, JobReport& report,
                  const Callbacks& callbacks) {
  MeasuredSurface& measured = report.surface.emplace();
  measured.level = surface.level();
  if (!made.source) {
    const PolygonMesh& mesh = made.input.file.mesh;
    measured.quality =
        surface.is_whole()
            ? surface_quality(surface.whole(), mesh)
            : surface_quality(surface.blocks(), mesh,
                              folded_edges(mesh, *made.prepared->topology).is_beside, callbacks);
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

void measure_surface(const JobInput& made, const Fit& fitted, JobLevel& surface, JobReport& report,
                     const JobContext& context) {
  if (surface.level() >= 1 && !report.surface) {
    note_quality(made, fitted, surface, report, callbacks_for(report, context));
    warn_of_folds(report, context.console);
  }
  if (surface.level() >= kPointDistanceLevel && !made.points.empty() && !report.point_distances) {
    const SurfaceMesh& whole = surface.whole();
    report.point_distances =
        relative(measure_distances(made.points, whole.positions, triangles_of(whole)),
                 fitted.placement.diagonal);
  }
}

}  // namespace planish::command
