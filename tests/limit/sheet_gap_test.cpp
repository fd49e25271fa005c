#include "planish/measure/figures.h"

#include <gtest/gtest.h>

#include <array>
#include <glm/geometric.hpp>
#include <memory>

#include "planish/mend/repair.h"
#include "planish/pipeline/fit.h"
#include "planish/solve/backend.h"
#include "support/meshes.h"

namespace planish {
namespace {

constexpr std::size_t kEdges = test::kBentEdges;

double gap_of(const PolygonMesh& mesh, const RepairedMesh& repaired, InterpolationMethod method) {
  const auto backend = make_cpu_backend({Precision::Double});
  FitOptions options;
  options.method = method;
  options.tolerance = 1e-10;
  const Fit fitted = fit(mesh, *backend, options);
  return sheet_gap(LimitSurface(fitted_surface(mesh, fitted)), repaired.source_vertices,
                   repaired.separated_edges) /
         fitted.placement.diagonal;
}

TEST(SheetGap, IsClosedByCornersAndSeenWithoutThem) {
  const RepairedMesh repaired = repair(test::bent_sheets());
  ASSERT_EQ(repaired.separated_edges.size(), kEdges);
  PolygonMesh smooth = repaired.mesh;
  smooth.corners.clear();
  for (const auto method : {InterpolationMethod::Progressive, InterpolationMethod::Fair}) {
    EXPECT_LT(gap_of(repaired.mesh, repaired, method), 1e-9);
    EXPECT_GT(gap_of(smooth, repaired, method), 1e-4);
  }
}

// Squares whose corners are corners: their boundaries are their edges.
TEST(SheetGap, IsTheDistanceOfTheCurves) {
  RepairedMesh copies;
  PolygonMesh& mesh = copies.mesh;
  for (const double z : {0.0, 0.25, 0.1}) {
    const std::int32_t first = mesh.vertex_count();
    mesh.positions.insert(mesh.positions.end(), {{0, 0, z}, {1, 0, z}, {1, 1, z}, {0, 1, z}});
    mesh.add_face(std::array{first, first + 1, first + 2, first + 3});
    copies.source_vertices.insert(copies.source_vertices.end(), {0, 1, first + 2, first + 3});
  }
  mesh.positions.push_back({7, 7, 7});  // of no face
  copies.source_vertices.push_back(12);
  for (std::int32_t v = 0; v < 12; ++v) mesh.corners.push_back({v});
  const EvaluateOptions options;
  const LimitSurface surface(std::make_shared<const DooSabinSurface>(mesh, options));
  const auto gap = [&](std::vector<std::pair<std::int32_t, std::int32_t>> edges) {
    return sheet_gap(surface, copies.source_vertices, edges);
  };
  EXPECT_NEAR(gap({{0, 1}}), 0.25, 1e-12);
  EXPECT_EQ(gap({{2, 3}}), 0) << "of one sheet only";
  EXPECT_EQ(gap({}), 0);
}

}  // namespace
}  // namespace planish
