#include "quality/wild_table.h"

#include <algorithm>
#include <cstdio>

#include "planish/backend/cpu_backend.h"
#include "planish/mesh/check.h"
#include "planish/mesh/convex_faces.h"
#include "planish/mesh/cusp_corners.h"
#include "planish/mesh/detect_creases.h"
#include "planish/mesh/folded_edges.h"
#include "planish/surface/surface_quality.h"

namespace planish::quality {

namespace {

constexpr double kFoldedPart = 1e-5;
constexpr int kLevels = 3;

struct WildFigures {
  double folded_elsewhere = 0, folded = 0, rms = 0;
};

WildFigures measure_wild(const PolygonMesh& mesh, InterpolationMethod method) {
  const auto backend = make_cpu_backend({Precision::Double});
  FitOptions options;
  options.method = method;
  const Fit fitted = fit(mesh, *backend, options);
  WildFigures figures;
  for (int level = 1; level <= kLevels; ++level) {
    EvaluateOptions at;
    at.level = level;
    at.rest_positions = mesh.positions;
    const SurfaceQuality quality = surface_quality(evaluate(mesh, fitted, *backend, at), mesh);
    figures.folded_elsewhere = std::max(figures.folded_elsewhere, quality.folded_area_elsewhere);
    figures.folded = std::max(figures.folded, quality.folded_area);
    if (level == 2) figures.rms = quality.rms_normal_deviation;
  }
  return figures;
}

void print_cell(const WildFigures& figures) {
  if (figures.folded_elsewhere > 0) {
    std::printf(" %.1e, %.2f |", figures.folded_elsewhere, figures.rms);
  } else {
    std::printf(" 0, %.2f |", figures.rms);
  }
}

}  // namespace

std::vector<std::string> print_wild_table(const std::vector<NamedCase>& cases) {
  std::printf(
      "| mesh (vertices; share of its area beside folded edges) | progressive | fair | fair, "
      "creases found |\n|---|--:|--:|--:|\n");
  std::vector<std::string> folded;
  for (const NamedCase& named : cases) {
    const PolygonMesh mesh = with_convex_faces(named.make().mesh).mesh;
    require_usable(mesh, named.name);
    std::printf("| %s (%d; %.2g) |", named.name.c_str(), mesh.vertex_count(),
                folded_edges(mesh).area);
    print_cell(measure_wild(mesh, InterpolationMethod::Progressive));
    const PolygonMesh with_cusps = with_cusp_corners(mesh);
    const WildFigures fair = measure_wild(with_cusps, InterpolationMethod::Fair);
    const WildFigures creased =
        measure_wild(with_detected_creases(with_cusps), InterpolationMethod::Fair);
    print_cell(fair);
    print_cell(creased);
    std::printf("\n");
    std::fflush(stdout);
    for (const auto& [figures, how] : {std::pair(fair, ""), {creased, " with creases found"}}) {
      if (figures.folded_elsewhere > kFoldedPart) folded.push_back(named.name + how + " folds");
    }
  }
  return folded;
}

}  // namespace planish::quality
