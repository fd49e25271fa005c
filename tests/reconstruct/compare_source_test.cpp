#include "planish/reconstruct/compare_source.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "planish/core/error.h"
#include "planish/solve/backend.h"
#include "planish/surface/doo_sabin_surface.h"
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

SourceComparison compare(const SurfaceMesh& surface, const PolygonMesh& source) {
  return compare_with_source(*blocks_of(surface, source), source);
}

TEST(CompareSource, MeasuresDistanceAndTurn) {
  // A large square through the origin that rises with x at 30 degrees.
  const double slope = std::tan(M_PI / 6);
  PolygonMesh source;
  source.positions = {
      {-9, -9, -9 * slope}, {9, -9, 9 * slope}, {9, 9, 9 * slope}, {-9, 9, -9 * slope}};
  source.add_face(std::array{0, 1, 2, 3});
  const SourceComparison comparison = compare(square(0), source);
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
  const SourceComparison comparison = compare(square(0), source);
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
  const SourceComparison comparison = compare(surface, cube);
  EXPECT_LT(comparison.quality.max_normal_deviation, 1e-4);
  EXPECT_LT(comparison.distances.max, 1e-12);
}

// A level that nobody holds has the figures of one that is held, found one by one.
TEST(CompareSource, BlocksHaveTheBitsOfTheWhole) {
  PolygonMesh mesh = test::cube();
  mesh.creases.push_back({0, 1, kInfiniteSharpness});
  PolygonMesh source = test::cube();
  for (glm::dvec3& position : source.positions) position *= glm::dvec3(0.9, 1.05, 1.0);
  const DooSabinSurface base(mesh, {});
  for (const int level : {1, 2, 5}) {
    const SurfaceMesh whole = evaluate(mesh, *make_cpu_backend(), {.level = level});
    std::vector<Triangle> triangles;
    for (std::int32_t f = 0; f < source.face_count(); ++f) {
      const auto face = source.face(f);
      triangles.push_back({face[0], face[1], face[2]});
      triangles.push_back({face[0], face[2], face[3]});
    }
    const TriangleTree tree(source.positions, triangles);
    const SurfaceQuality wanted =
        surface_quality(whole, [&](std::int64_t face, std::int32_t corner) {
          const auto vertices = whole.face(face);
          glm::dvec3 middle(0.0);
          for (const std::int32_t v : vertices) middle += whole.positions[v];
          middle /= 4.0;
          const glm::dvec3& at = whole.positions[vertices[corner]];
          const Triangle& t = triangles[tree.nearest(at + 0.01 * (middle - at)).triangle];
          return glm::cross(source.positions[t[1]] - source.positions[t[0]],
                            source.positions[t[2]] - source.positions[t[0]]);
        });
    const PointDistances distances =
        measure_distances(whole.positions, source.positions, triangles);
    const SourceComparison found = compare_with_source(*base.level(level), source);
    EXPECT_EQ(found.quality.rms_normal_deviation, wanted.rms_normal_deviation);
    EXPECT_EQ(found.quality.max_normal_deviation, wanted.max_normal_deviation);
    EXPECT_EQ(found.quality.bending, wanted.bending);
    EXPECT_EQ(found.quality.folded_area, wanted.folded_area);
    EXPECT_GT(found.distances.max, 0);
    EXPECT_EQ(found.distances.max, distances.max);
    EXPECT_EQ(found.distances.rms, distances.rms);
    EXPECT_EQ(found.distances.farthest, distances.farthest);
  }
}

TEST(CompareSource, AnEmptySourceIsRefused) { EXPECT_THROW((void)compare(square(0), {}), Error); }

}  // namespace
}  // namespace planish
