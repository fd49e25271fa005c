#include "planish/pipeline/fit_best.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "planish/backend/cpu_backend.h"
#include "support/delaunay_sphere.h"
#include "support/meshes.h"

namespace planish::test {
namespace {

using testing::HasSubstr;

TEST(FitBest, TakesFairWhereProgressiveFolds) {
  const auto backend = make_cpu_backend();
  const BestFit best = fit_best(delaunay_sphere(600, 1), *backend);
  EXPECT_EQ(best.method, InterpolationMethod::Fair);
  ASSERT_TRUE(best.fit.fair.has_value());
  EXPECT_GT(best.progressive.folded_area_elsewhere, 1e-4);
  EXPECT_LT(best.fair.folded_area_elsewhere, 1e-5);
  EXPECT_THAT(best.reason, HasSubstr("fair: progressive folds"));
}

TEST(FitBest, TakesFairWhereBothAreAlike) {
  const auto backend = make_cpu_backend();
  const BestFit best = fit_best(torus(24, 12, 1, 0.4), *backend);
  EXPECT_EQ(best.method, InterpolationMethod::Fair);
  EXPECT_EQ(best.progressive.folded_area, 0.0);
  EXPECT_THAT(best.reason, HasSubstr("not clearly less"));
}

// The figures that decide are those of the surfaces themselves.
TEST(FitBest, ItsFiguresAreThoseOfBothSurfaces) {
  const auto backend = make_cpu_backend();
  const PolygonMesh mesh = icosphere(2);
  const BestFit best = fit_best(mesh, *backend);
  const SurfaceQuality expected = surface_quality(
      evaluate(mesh, fit(mesh, *backend), *backend, EvaluateOptions{.level = 1}), mesh);
  EXPECT_EQ(best.progressive.rms_normal_deviation, expected.rms_normal_deviation);
  const bool progressive =
      best.progressive.rms_normal_deviation < 0.9 * best.fair.rms_normal_deviation;
  EXPECT_EQ(best.method == InterpolationMethod::Progressive, progressive);
  EXPECT_EQ(best.fit.fair.has_value(), !progressive);
}

}  // namespace
}  // namespace planish::test
