#include "quality/wild_table.h"

#include <algorithm>
#include <cstdio>

#include "planish/backend/cpu_backend.h"
#include "planish/mesh/check.h"
#include "planish/mesh/convex_faces.h"
#include "planish/mesh/cusp_corners.h"
#include "planish/mesh/folded_edges.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/pipeline/found_creases.h"
#include "planish/surface/surface_quality.h"

namespace planish::quality {

namespace {

constexpr double kFoldedPart = 1e-5;
constexpr int kLevels = 3;

struct WildFigures {
  double folded_elsewhere = 0, folded = 0, rms = 0;
};

WildFigures measure_wild(const PolygonMesh& mesh, const Fit& fitted, Backend& backend) {
  WildFigures figures;
  for (int level = 1; level <= kLevels; ++level) {
    EvaluateOptions at;
    at.level = level;
    at.rest_positions = mesh.positions;
    const SurfaceQuality quality = surface_quality(evaluate(mesh, fitted, backend, at), mesh);
    figures.folded_elsewhere = std::max(figures.folded_elsewhere, quality.folded_area_elsewhere);
    figures.folded = std::max(figures.folded, quality.folded_area);
    if (level == 2) figures.rms = quality.rms_normal_deviation;
  }
  return figures;
}

WildFigures of_method(const PolygonMesh& mesh, InterpolationMethod method, Backend& backend) {
  FitOptions options;
  options.method = method;
  return measure_wild(mesh, fit(mesh, backend, options), backend);
}

WildFigures with_creases(PolygonMesh mesh, Backend& backend) {
  const FoundCreases found = add_features(mesh, prepare_mesh(mesh, "mesh"));
  const CreasedFit creased = fit_with_found_creases(mesh, found, backend, {});
  return measure_wild(mesh, creased.fit, backend);
}

WildFigures chosen(const PolygonMesh& mesh, Backend& backend) {
  MeshFitOptions options;
  options.refine = RefineChoice::Off;
  const FittedMesh best = fit_mesh(mesh, "mesh", backend, options);
  return measure_wild(best.mesh, best.fit, backend);
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
      "creases found | auto |\n|---|--:|--:|--:|--:|\n");
  const auto backend = make_cpu_backend({Precision::Double});
  std::vector<std::string> folded;
  for (const NamedCase& named : cases) {
    const PolygonMesh mesh = with_convex_faces(named.make().mesh).mesh;
    require_usable(mesh, named.name);
    std::printf("| %s (%d; %.2g) |", named.name.c_str(), mesh.vertex_count(),
                folded_edges(mesh).area);
    print_cell(of_method(mesh, InterpolationMethod::Progressive, *backend));
    const PolygonMesh with_cusps = with_cusp_corners(mesh);
    const WildFigures fair = of_method(with_cusps, InterpolationMethod::Fair, *backend);
    const WildFigures creased = with_creases(with_cusps, *backend);
    const WildFigures taken = chosen(mesh, *backend);
    for (const WildFigures& figures : {fair, creased, taken}) print_cell(figures);
    std::printf("\n");
    std::fflush(stdout);
    for (const auto& [figures, how] :
         {std::pair(fair, ""), {creased, " with creases found"}, {taken, " by auto"}}) {
      if (figures.folded_elsewhere > kFoldedPart) folded.push_back(named.name + how + " folds");
    }
    if (creased.folded_elsewhere > fair.folded_elsewhere)
      folded.push_back(named.name + " folds more with creases found than without");
  }
  return folded;
}

}  // namespace planish::quality
