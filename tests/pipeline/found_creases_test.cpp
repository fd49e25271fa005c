#include "planish/pipeline/fit_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "planish/pipeline/fit_mesh.h"
#include "planish/solve/backend.h"
#include "planish/surface/quality_sum.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish {
namespace {

double folds_of(const PolygonMesh& mesh, const Fit& fitted, Backend& backend) {
  double area = 0;
  for (const int level : {1, 2, 3}) {
    const SurfaceMesh surface = evaluate(mesh, fitted, backend, {.level = level});
    area = std::max(area, surface_quality(surface, mesh).folded_area_elsewhere);
  }
  return area;
}

double fair_folds(const PolygonMesh& mesh, Backend& backend) {
  FitOptions options;
  options.method = InterpolationMethod::Fair;
  return folds_of(mesh, fit(mesh, backend, options), backend);
}

std::vector<std::pair<std::int32_t, std::int32_t>> edges_of(const PolygonMesh& mesh) {
  std::vector<std::pair<std::int32_t, std::int32_t>> edges;
  for (const CreaseEdge& crease : mesh.creases) edges.emplace_back(crease.v0, crease.v1);
  return edges;
}

// Two finely drawn bands along three quarters of a circle above each other, and quads between.
PolygonMesh arc_plate(int n) {
  PolygonMesh mesh = test::prism(n);
  const int half = n / 2;
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const int i = v % n;
    const bool is_outer = i < half;
    const double along = static_cast<double>(is_outer ? i : n - 1 - i) / (half - 1);
    const double angle = 1.5 * std::numbers::pi * along, radius = is_outer ? 1 : 0.7;
    mesh.positions[v].x = radius * std::cos(angle);
    mesh.positions[v].y = radius * std::sin(angle);
  }
  return mesh;
}

// The finer one folds by 2e-4 of the area at level 3, for which 5 % of its creases are too many.
TEST(FoundCreases, StayAroundFinelyDrawnPlates) {
  const auto backend = make_cpu_backend();
  for (const int corners : {1000, 10'000}) {
    const FittedMesh fitted = fit_mesh(arc_plate(corners), "plate", *backend);
    EXPECT_EQ(fitted.mesh.creases.size(), 2u * static_cast<unsigned>(corners) + 4);
    EXPECT_EQ(fitted.rounded_count, 0);
    const SurfaceQuality quality =
        surface_quality(evaluate(fitted.mesh, fitted.fit, *backend, {.level = 1}), fitted.mesh);
    EXPECT_LT(quality.rms_normal_deviation, 0.5) << corners;
    EXPECT_EQ(quality.folded_area, 0) << corners;
  }
}

TEST(FoundCreases, AreTakenBackWhereTheyFoldTheSurface) {
  const auto backend = make_cpu_backend({Precision::Double});
  int taken_back = 0;
  for (std::uint32_t seed = 1; seed <= 3; ++seed) {
    const PolygonMesh given = test::jittered(test::icosphere(2), 0.25, seed);
    PolygonMesh mesh = given;
    const auto prepared = prepare_mesh(mesh, "ball");
    const FoundCreases found = add_features(mesh, prepared, {.every = 30});
    const PolygonMesh all = mesh;
    const CreasedFit creased = fit_with_found_creases(mesh, found, *backend, {});
    const double area = folds_of(mesh, creased.fit, *backend);
    EXPECT_LE(area, fair_folds(given, *backend)) << seed;
    EXPECT_LE(area, fair_folds(all, *backend)) << seed;
    taken_back += creased.found.edges.size() < found.edges.size();
    // What is left alone says which tags there are.
    PolygonMesh again = given;
    add_tags(again, creased.found);
    EXPECT_EQ(edges_of(again), edges_of(mesh));
    EXPECT_EQ(again.corners.size(), mesh.corners.size());
  }
  EXPECT_GT(taken_back, 0);
}

TEST(FoundCreases, StayWhereNothingFolds) {
  const auto backend = make_cpu_backend({Precision::Double});
  PolygonMesh mesh = test::cube();
  const FoundCreases found = add_features(mesh, prepare_mesh(mesh, "cube"));
  const CreasedFit creased = fit_with_found_creases(mesh, found, *backend, {});
  EXPECT_EQ(mesh.creases.size(), 12u);
  EXPECT_EQ(creased.found.edges.size(), 12u);
  EXPECT_EQ(creased.fit.sharp_edge_count, 12);
}

TEST(FoundCreases, LeaveGivenTagsAlone) {
  PolygonMesh mesh = test::cube();
  mesh.creases = {{0, 1}};
  const auto prepared = prepare_mesh(mesh, "cube");
  FoundCreases found = add_features(mesh, prepared);
  EXPECT_EQ(mesh.creases.size(), 12u);
  const std::vector<std::int32_t> smooth{0};
  leave_smooth(mesh, found, smooth);
  EXPECT_EQ(mesh.creases.size(), 10u) << "of three at the vertex one is the file's";
  EXPECT_EQ(found.edges.size(), 9u);
}

TEST(FoundCreases, GiveTheWarningsOfTheFitThatIsTaken) {
  const auto backend = make_cpu_backend({Precision::Double});
  int folded = 0;
  for (const double amount : {0.5, 1.0, 2.0, 4.0, 8.0}) {
    PolygonMesh mesh = test::jittered(test::icosphere(2), amount, 1);
    const FoundCreases found;
    std::vector<Warning> warnings;
    FitOptions options;
    options.callbacks.warning = [&](const Warning& warning) { warnings.push_back(warning); };
    const CreasedFit creased = fit_with_found_creases(mesh, found, *backend, options);
    const std::int64_t left = creased.fit.fair->flagged_edges + creased.fit.fair->flagged_faces;
    ASSERT_EQ(warnings.size(), left > 0 ? 1u : 0u) << amount;
    if (left == 0) continue;
    ++folded;
    EXPECT_EQ(warnings[0].code, "folds-left");
    EXPECT_EQ(warnings[0].count, left);
  }
  EXPECT_GT(folded, 0) << "else nothing was tested";
}

}  // namespace
}  // namespace planish
