#include "planish/reconstruct/compare_source.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "planish/backend/cpu_backend.h"
#include "planish/core/error.h"
#include "planish/surface/evaluate.h"
#include "support/meshes.h"

namespace planish {
namespace {

// A square of side 1 at the given height, facing up.
SurfaceMesh square(double height) {
  SurfaceMesh surface;
  surface.level = 1;
  surface.positions = {{0, 0, height}, {1, 0, height}, {1, 1, height}, {0, 1, height}};
  surface.face_vertices = {0, 1, 2, 3};
  surface.normals.assign(4, glm::vec3(0, 0, 1));
  return surface;
}

TEST(CompareSource, MeasuresDistanceAndTurn) {
  // A large square through the origin that rises with x at 30 degrees.
  const double slope = std::tan(M_PI / 6);
  PolygonMesh source;
  source.positions = {
      {-9, -9, -9 * slope}, {9, -9, 9 * slope}, {9, 9, 9 * slope}, {-9, 9, -9 * slope}};
  source.add_face(std::array{0, 1, 2, 3});
  const SourceComparison comparison = compare_with_source(square(0), source);
  EXPECT_NEAR(comparison.quality.rms_normal_deviation, 30.0, 1e-9);
  EXPECT_NEAR(comparison.quality.max_normal_deviation, 30.0, 1e-9);
  EXPECT_EQ(comparison.quality.folded_area, 0.0);
  // Two corners lie on it, two at height -x slope from it: half of that by the cosine.
  EXPECT_NEAR(comparison.distances.max, 0.5, 1e-12);
  EXPECT_NEAR(comparison.distances.rms, 0.5 / std::sqrt(2.0), 1e-12);
}

TEST(CompareSource, ATurnedSourceIsAllFolds) {
  PolygonMesh source;
  source.positions = {{-9, -9, 1}, {9, -9, 1}, {9, 9, 1}, {-9, 9, 1}};
  source.add_face(std::array{0, 3, 2, 1});
  const SourceComparison comparison = compare_with_source(square(0), source);
  EXPECT_EQ(comparison.quality.folded_area, 1.0);
  EXPECT_DOUBLE_EQ(comparison.distances.rms, 1.0);
}

TEST(CompareSource, BothSidesOfACreaseFindTheirOwn) {
  PolygonMesh cube = test::cube();
  for (std::int32_t a = 0; a < 8; ++a) {
    for (const std::int32_t bit : {1, 2, 4}) {
      if ((a & bit) == 0) cube.creases.push_back({a, a | bit, kInfiniteSharpness});
    }
  }
  const SurfaceMesh surface = evaluate(cube, *make_cpu_backend(), {.level = 3});
  const SourceComparison comparison = compare_with_source(surface, cube);
  EXPECT_LT(comparison.quality.max_normal_deviation, 1e-4);
  EXPECT_LT(comparison.distances.max, 1e-12);
}

TEST(CompareSource, AnEmptySourceIsRefused) {
  EXPECT_THROW((void)compare_with_source(square(0), {}), Error);
}

}  // namespace
}  // namespace planish
