// Freeform faces beside faces on surfaces: how they are moved onto these, and parts that have both.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <string>
#include <vector>

#include "analytic/mixed_shapes.h"
#include "analytic/profile.h"
#include "brep/step_checks.h"
#include "planish/brep/moved_faces.h"
#include "planish/c/handles.h"
#include "planish/files/mesh_file.h"
#include "planish/job/fit_file.h"
#include "planish/pipeline/write_fitted_step.h"

namespace planish::test {
namespace {

// A spline with knots of all sizes.
QuadraticCurve some_curve() {
  return {.knots = {0, 0.125, 1, 3},
          .points = {{0, 0, 0}, {1, 2, 0}, {2, -1, 1}, {4, 0, 2}, {5, 1, -1}}};
}

TEST(QuadraticCurves, AreToldByTheirValues) {
  const QuadraticCurve curve = some_curve();
  const auto at = [&](double t) { return curve.at(t); };
  const std::vector<glm::dvec3> points = quadratic_points(curve.knots, at);
  ASSERT_EQ(points.size(), curve.points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_LT(glm::length(points[i] - curve.points[i]), 1e-14);
  // With more knots it is the same curve.
  std::vector<double> knots = curve.knots;
  add_fading_knots(2, knots);
  const QuadraticCurve finer{.knots = knots, .points = quadratic_points(knots, at)};
  EXPECT_EQ(knots.size(), 6u);
  for (double t = 0; t <= 3; t += 1.0 / 64)
    EXPECT_LT(glm::length(finer.at(t) - curve.at(t)), 1e-14);
}

TEST(QuadraticCurves, HavePartsBothWays) {
  const QuadraticCurve curve = some_curve();
  for (const auto& [from, to] : {std::pair{0.0625, 2.5}, std::pair{2.5, 0.0625}}) {
    const QuadraticCurve part = curve.part(from, to);
    EXPECT_EQ(part.knots.front(), 0);
    EXPECT_EQ(part.knots.back(), 2.4375);
    for (double t = 0; t <= 2.4375; t += 1.0 / 64)
      EXPECT_LT(glm::length(part.at(t) - curve.at(from < to ? from + t : from - t)), 1e-14);
  }
}

TEST(QuadraticCurves, ComeAsNearAsIsAskedFor) {
  const auto circle = [](double t) { return glm::dvec3(std::cos(t), std::sin(t), 0); };
  for (const double tolerance : {1e-4, 1e-8}) {
    const auto curve = curve_near({0, 1, 2}, circle, tolerance);
    ASSERT_TRUE(curve);
    for (double t = 0; t <= 2; t += 1.0 / 333)
      EXPECT_LT(glm::length(curve->at(t) - circle(t)), 1.5 * tolerance);
  }
  EXPECT_FALSE(curve_near(
      {0, 1}, [](double t) { return glm::dvec3(t < 1 / 3.0 ? 0 : 1, 0, 0); }, 1e-8));
}

// A face of three by two squares.
Brep::Face some_face() {
  Brep::Face face{.knots_u = {0, 1, 2, 3}, .knots_v = {0, 1, 2}};
  for (std::size_t i = 0; i < 5 * 4; ++i) {
    const double x = static_cast<double>(i % 5), y = static_cast<double>(i / 5);
    face.points.emplace_back(x, y, std::sin(x) * std::cos(y));
  }
  return face;
}

TEST(MovedFaces, FollowTheirSidesAndStayElsewhere) {
  const Brep brep;
  const Brep::Face before = some_face();
  Brep::Face after = before;
  // Both sides at the corner (0, 0).
  const glm::dvec3 corner(0.01, 0.02, -0.03);
  const auto below = [&](double u) { return (1 - u / 3) * (1 - u / 3) * corner; };
  const auto left = [&](double v) { return fading(v) * corner; };
  std::array<MovedSide, 4> sides;
  sides[0] = {before.knots_u, below};
  sides[3] = {{0, 0.5, 1, 2}, left};
  move_sides(brep, sides, after);
  const auto moved_by = [&](double u, double v) {
    return point_of(brep, after, {u, v}) - point_of(brep, before, {u, v});
  };
  for (double t = 0; t <= 3; t += 1.0 / 32)
    EXPECT_LT(glm::length(moved_by(t, 0) - below(t)), 1e-14);
  for (double t = 0; t <= 2; t += 1.0 / 32) {
    EXPECT_LT(glm::length(moved_by(0, t) - left(t)), 1e-14);
    EXPECT_LT(glm::length(moved_by(3, t)), 1e-14);
    for (double u = 1; u <= 3; u += 1.0 / 16) EXPECT_LT(glm::length(moved_by(u, 1 + t / 2)), 1e-14);
  }
}

FittedMesh fitted_of(const PolygonMesh& mesh, QuadChoice quads = QuadChoice::Auto) {
  MeshFitOptions how;
  how.quads = quads;
  return fit_mesh(mesh, "part", *make_cpu_backend(), how);
}

void expect_mixed(const MixedShape& shape, const PolygonMesh& mesh) {
  const FittedMesh fitted = fitted_of(mesh);
  const StepFigures figures = write_fitted_step(scratch("mixed.step"), fitted, {});
  EXPECT_EQ(figures.mixed_parts, 1) << figures.freeform_reason;
  EXPECT_EQ(figures.freeform_parts, 0);
  EXPECT_EQ(figures.analytic, shape.kinds);
  EXPECT_GT(figures.faces, std::ssize(StepFile(scratch("mixed.step")).all("PLANE")));
  EXPECT_EQ(figures.solids, 1);
  EXPECT_TRUE(figures.check.is_valid());
  EXPECT_LE(figures.check.largest_gap, 5e-8);
  const double diagonal = fitted.fit.placement.diagonal;
  EXPECT_LE(figures.largest_distance, 2e-6 * diagonal);
  // Far fewer than without these surfaces.
  StepFileOptions off;
  off.settings.analytic = AnalyticChoice::Off;
  EXPECT_LT(figures.faces, write_fitted_step(scratch("splines.step"), fitted, off).faces);
}

TEST(MixedParts, HaveTheirSurfacesBesideFreeformFaces) {
  for (const MixedShape& shape : mixed_shapes()) {
    SCOPED_TRACE(shape.name);
    expect_mixed(shape, shape.mesh);
  }
}

TEST(MixedParts, HaveThemTurnedMovedAndScaled) {
  for (const MixedShape& shape : mixed_shapes()) {
    SCOPED_TRACE(shape.name);
    expect_mixed(shape, posed(shape.mesh));
  }
}

// Two of them, one of which is freeform altogether: each is as it is alone.
TEST(MixedParts, AreTakenOneByOne) {
  const MixedShape shape = mixed_shapes().front();
  const PolygonMesh both = beside(shape.mesh, jittered(torus(14, 10, 2, 0.7), 0.05, 4), 9);
  const StepFigures figures = write_fitted_step(scratch("two_parts.step"), fitted_of(both), {});
  EXPECT_EQ(figures.mixed_parts, 1);
  EXPECT_EQ(figures.freeform_parts, 1);
  EXPECT_EQ(figures.analytic, shape.kinds);
  EXPECT_EQ(figures.solids, 2);
  EXPECT_TRUE(figures.check.is_valid());
}

// What ends at a surface moves onto it, by more than a fine tolerance; the file's digits keep all.
TEST(MixedParts, AreSaidToBeRoundedByNoFile) {
  const MixedShape shape = mixed_shapes().front();
  write_mesh(scratch("mixed.obj"), FileFormat::Obj, shape.mesh);
  FitFileOptions options;
  options.settings.tolerance = 1e-12;
  const FileFit done = fit_file(scratch("mixed.obj"), scratch("mixed_fit.step"), options);
  ASSERT_TRUE(done.step);
  ASSERT_EQ(done.step->mixed_parts, 1);
  EXPECT_GT(done.step->largest_distance, 1e-12 * done.fitted.fit.placement.diagonal);
  EXPECT_EQ(std::ranges::find(done.fitted.warnings, "rounded-output", &Warning::code),
            done.fitted.warnings.end());
}

}  // namespace
}  // namespace planish::test
