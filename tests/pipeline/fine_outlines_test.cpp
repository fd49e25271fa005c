// Flat parts with finely drawn outlines by default: all sharp edges kept, no fold.
#include <gtest/gtest.h>

#include <algorithm>
#include <tuple>

#include "planish/mend/faults.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/solve/backend.h"
#include "planish/surface/quality_sum.h"
#include "support/outlines.h"

namespace planish::test {
namespace {

// The largest folded part of levels 1 to 3.
double folded_area(const PolygonMesh& mesh, const Fit& fit, Backend& backend) {
  double area = 0;
  for (const int level : {1, 2, 3})
    area = std::max(
        area, surface_quality(evaluate(mesh, fit, backend, {.level = level}), mesh).folded_area);
  return area;
}

TEST(FineOutlines, KeepTheirRimsWithoutFolds) {
  // `upright`: sharp edges between the rims. `degrees`: the walls turn by so much at a corner.
  const std::tuple<const char*, Outline, int, double> cases[] = {
      {"rounded square", rounded_square(100, 0.5), 0, 0.3},
      {"square with small arcs", rounded_square(32, 0.1), 0, 0.5},
      {"slot", slot(100, 4), 0, 0.5},
      {"half disc", pie_slice(300, 180), 2, 0.3},
      {"pie slice", pie_slice(100, 90), 3, 0.3},
      {"gear", gear_outline(8, 32), 32, 0.3},
      {"cam of 500", cam(500, 1), 0, 0.6},
      {"another", cam(1000, 5), 0, 0.6}};
  const auto backend = make_cpu_backend();
  for (const auto& [name, outline, upright, degrees] : cases) {
    SCOPED_TRACE(name);
    const PolygonMesh mesh = prism_over(outline);
    const FittedMesh fitted = fit_mesh(mesh, "outline", *backend);
    EXPECT_EQ(fitted.mesh.creases.size(), 2 * outline.size() + std::size_t(upright));
    EXPECT_LT(folded_area(fitted.mesh, fitted.fit, *backend), 1e-5);
    const SurfaceMesh surface = evaluate(fitted.mesh, fitted.fit, *backend, {.level = 2});
    EXPECT_LT(surface_quality(surface, fitted.mesh).rms_normal_deviation, degrees);
  }
}

// What kMostSwirl stands for.
TEST(FineOutlines, FoldWhereTheirCornersSwirlAndNothingIsCut) {
  const auto backend = make_cpu_backend();
  FitOptions options;
  options.method = InterpolationMethod::Fair;
  options.cures_folds = false;
  for (const auto& [steps, least, most] :
       {std::tuple(8, 0.0, 0.0), {16, 0.0, 0.0}, {100, 1e-3, 1.0}, {300, 1e-2, 1.0}}) {
    const Outline outline = rounded_square(steps, 0.5);
    EXPECT_EQ(corner_swirl(outline) > kMostSwirl, least > 0) << steps;
    const PolygonMesh mesh = with_sharp_rims(prism_over(outline));
    const double folded = folded_area(mesh, fit(mesh, *backend, options), *backend);
    EXPECT_GE(folded, least) << steps;
    EXPECT_LE(folded, most) << steps;
  }
}

}  // namespace
}  // namespace planish::test
