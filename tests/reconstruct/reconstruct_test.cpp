#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <random>
#include <stdexcept>
#include <vector>

#include "planish/core/error.h"
#include "planish/reconstruct/compare_source.h"
#include "planish/reconstruct/reconstruct.h"
#include "planish/solve/backend.h"
#include "planish/surface/doo_sabin_surface.h"
#include "planish/surface/evaluate.h"
#include "reconstruct/test_clouds.h"
#include "support/calls.h"
#include "support/meshes.h"

namespace planish {
namespace {

using testing::HasSubstr;

// A mesher that knows the answer.
Mesher given(std::vector<Triangle> triangles) {
  return [triangles](std::span<const glm::dvec3>, const Callbacks&) { return triangles; };
}

std::vector<std::string> codes_of(const PointCloud& cloud, const Mesher& mesher,
                                  ReconstructOptions options) {
  std::vector<std::string> codes;
  options.callbacks.warning = [&](const Warning& w) { codes.push_back(w.code); };
  (void)reconstruct(cloud, mesher, options);
  return codes;
}

TEST(Reconstruct, GivesPlacesOfTheFileBack) {
  const test::TriangleMesh torus = test::torus_mesh(60, 30);
  PointCloud cloud{.points = torus.positions};
  std::vector<glm::dvec3> places;
  for (glm::dvec3& p : cloud.points) places.push_back(p += glm::dvec3(4e5, 5e6, 0));
  recentre(cloud);
  ASSERT_NE(cloud.origin.x, 0);
  const Reconstruction result = reconstruct(cloud, given(torus.triangles), {.tolerance = 1e-3});
  EXPECT_LT(result.statistics.vertex_count, 1200);
  EXPECT_LE(result.distances.max, 1e-3 * result.diagonal);
  for (std::size_t v = 0; v < result.vertex_points.size(); ++v)
    EXPECT_EQ(result.mesh.positions[v], places[result.vertex_points[v]]);
}

TEST(Reconstruct, KeepsEveryPointAtToleranceZero) {
  const test::TriangleMesh torus = test::torus_mesh(30, 20);
  const Reconstruction result =
      reconstruct({.points = torus.positions}, given(torus.triangles), {.tolerance = 0});
  EXPECT_EQ(result.statistics.vertex_count, 600);
  EXPECT_EQ(result.mesh.positions, torus.positions);
}

TEST(Reconstruct, SaysWhatItCouldNotDo) {
  const test::TriangleMesh grid = test::grid_mesh(20, [](int, int) { return 0.0; });
  EXPECT_THAT(codes_of({.points = grid.positions}, given(grid.triangles), {}),
              testing::ElementsAre("open-mesh"));
  test::TriangleMesh torus = test::torus_mesh(30, 20);
  EXPECT_THAT(codes_of({.points = torus.positions}, given(torus.triangles),
                       {.tolerance = 1e-5, .target_vertices = 10}),
              testing::ElementsAre("target-not-reached"));
  torus.positions.emplace_back(0, 0, 0.1);
  EXPECT_THAT(codes_of({.points = torus.positions}, given(torus.triangles),
                       {.clean = {.outliers = OutlierRule::Off}}),
              testing::ElementsAre("points-left-out"));
}

TEST(Reconstruct, ChoosesByTheNoise) {
  test::TriangleMesh torus = test::torus_mesh(90, 45);
  const double diagonal = diagonal_of(torus.positions);
  const Mesher mesher = given(torus.triangles);
  const Reconstruction clean = reconstruct({.points = torus.positions}, mesher, {});
  EXPECT_EQ(clean.smooth_rounds, 0);
  EXPECT_EQ(clean.tolerance, 1e-4);
  test::add_noise(torus.positions, 0.06, 5);
  const PointCloud cloud{.points = torus.positions};
  const Reconstruction noisy = reconstruct(cloud, mesher, {});
  EXPECT_NEAR(noisy.noise, 0.06 / std::sqrt(12), 0.004);
  EXPECT_GE(noisy.smooth_rounds, 1);
  EXPECT_EQ(noisy.tolerance, noisy.noise / noisy.diagonal);
  EXPECT_NEAR(noisy.diagonal, diagonal, 0.1);
  // Smoothing takes away more than half of what the same points have without it.
  const Reconstruction as_given = reconstruct(cloud, mesher, {.smooth_rounds = 0});
  EXPECT_LT(test::rms_distance_to_torus(noisy.mesh.positions),
            0.6 * test::rms_distance_to_torus(as_given.mesh.positions));
  // What is asked for counts, and what keeps every point keeps its place.
  EXPECT_EQ(reconstruct(cloud, mesher, {.tolerance = 0.02}).tolerance, 0.02);
  const Reconstruction all = reconstruct(cloud, mesher, {.tolerance = 0});
  EXPECT_EQ(all.smooth_rounds, 0);
  EXPECT_EQ(all.mesh.positions, torus.positions);
  EXPECT_EQ(reconstruct(cloud, mesher, {.measure_noise = false}).smooth_rounds, 0);
  EXPECT_THAT(codes_of(cloud, mesher, {.tolerance = 1e-3}),
              testing::ElementsAre("tolerance-below-noise"));
  EXPECT_THAT(codes_of(cloud, mesher, {.tolerance = 0.02, .smooth_rounds = 0}), testing::IsEmpty());
}

// Their Delaunay triangulation takes the square of their number: no mesher is asked.
TEST(Reconstruct, RefusesPointsAlongALine) {
  const Mesher unasked = [](std::span<const glm::dvec3>,
                            const Callbacks&) -> std::vector<Triangle> {
    throw std::logic_error("asked");
  };
  for (const std::int64_t coarse_from : {std::int64_t{1} << 40, std::int64_t{1000}}) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> along(0, 1);
    PointCloud line;
    for (int i = 0; i < 20'000; ++i)
      line.points.emplace_back(glm::vec3(along(random) * glm::dvec3(1, 2, 3)));
    const auto refusal = [&](std::optional<double> tolerance) {
      return test::message_of(ErrorCode::UnusableMesh, [&] {
        (void)reconstruct(line, unasked, {.tolerance = tolerance, .coarse_from = coarse_from});
      });
    };
    EXPECT_THAT(
        refusal({}),
        HasSubstr("points lie on a line, but for 0.0001 of its length, and span no surface; "
                  "a smaller --tolerance-mesh keeps what is thinner"));
    EXPECT_THAT(refusal(1e-9), HasSubstr("but for 1e-06 of its length, and span no surface"));
  }
}

TEST(Reconstruct, WarnsOfPartsThatTheToleranceSwallows) {
  test::TriangleMesh torus = test::torus_mesh(60, 30);
  const std::size_t count = torus.positions.size();
  for (const glm::dvec3 off : {glm::dvec3(3e6, 0, 0), glm::dvec3(0, 3e6, 0)})
    for (std::size_t i = 0; i < count; ++i) torus.positions.push_back(torus.positions[i] + off);
  std::vector<Warning> warnings;
  ReconstructOptions options{.clean = {.outliers = OutlierRule::Off}, .measure_noise = false};
  options.callbacks.warning = [&](const Warning& w) { warnings.push_back(w); };
  (void)reconstruct({.points = torus.positions}, given(torus.triangles), options);
  ASSERT_FALSE(warnings.empty());
  EXPECT_EQ(warnings.front().code, "coarse-tolerance");
  EXPECT_THAT(warnings.front().message, HasSubstr("--tolerance-mesh "));
}

TEST(Reconstruct, RefusesWhatIsNoSurface) {
  EXPECT_THAT(
      test::message_of(ErrorCode::UnusableMesh, [] { (void)reconstruct({}, given({}), {}); }),
      HasSubstr("0 points are left"));
  const PointCloud cloud{.points = test::torus_points(50, 1)};
  EXPECT_THAT(
      test::message_of(ErrorCode::UnusableMesh, [&] { (void)reconstruct(cloud, given({}), {}); }),
      HasSubstr("no surface was found in 50 points"));
  EXPECT_THAT(test::message_of(ErrorCode::InvalidArgument,
                               [&] { (void)reconstruct(cloud, given({}), {.tolerance = -1}); }),
              HasSubstr("tolerance-mesh"));
}

// A square of side 18 about the origin that rises with x, facing up.
PolygonMesh large_square(double slope, double height) {
  PolygonMesh mesh;
  for (const auto& [x, y] : {std::pair(-9, -9), {9, -9}, {9, 9}, {-9, 9}})
    mesh.positions.emplace_back(x, y, height + slope * x);
  mesh.add_face(std::array{0, 1, 2, 3});
  return mesh;
}

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
  const SourceComparison comparison =
      compare(square(0), large_square(std::tan(M_PI / 6), 0));  // at 30 degrees
  EXPECT_NEAR(comparison.quality.rms_normal_deviation, 30.0, 1e-9);
  EXPECT_NEAR(comparison.quality.max_normal_deviation, 30.0, 1e-9);
  EXPECT_EQ(comparison.quality.folded_area, 0.0);
  // Two corners lie on it, two at height -x slope from it: half of that by the cosine.
  EXPECT_NEAR(comparison.distances.max, 0.5, 1e-12);
  EXPECT_NEAR(comparison.distances.rms, 0.5 / std::sqrt(2.0), 1e-12);
}

TEST(CompareSource, ATurnedSourceIsAllFolds) {
  PolygonMesh source = large_square(0, 1);
  std::ranges::reverse(source.face_vertices);
  const SourceComparison comparison = compare(square(0), source);
  EXPECT_EQ(comparison.quality.folded_area, 1.0);
  EXPECT_DOUBLE_EQ(comparison.distances.rms, 1.0);
}

TEST(CompareSource, BothSidesOfACreaseFindTheirOwn) {
  const PolygonMesh cube = test::creased_cube();
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
