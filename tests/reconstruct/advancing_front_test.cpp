#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "planish/mesh/polygon_mesh.h"
#include "planish/reconstruct/cgal/advancing_front.h"
#include "planish/reconstruct/mesher_process.h"
#include "planish/reconstruct/reconstruct.h"
#include "planish/reconstruct/reconstruct_steps.h"
#include "reconstruct/test_clouds.h"
#include "support/calls.h"

namespace planish {
namespace {

using testing::HasSubstr;

const std::filesystem::path kProgram = PLANISH_RECONSTRUCT_PROGRAM;

TEST(AdvancingFront, MeshesATorusThroughEveryPoint) {
  const PointCloud cloud{.points = test::torus_points(6000, 21)};
  std::vector<double> fractions;
  ReconstructOptions options{.tolerance = 0, .clean = {.outliers = OutlierRule::Off}};
  options.callbacks.progress = [&](std::string_view, double f) { fractions.push_back(f); };
  const Reconstruction result = reconstruct(cloud, mesh_by_advancing_front, options);
  EXPECT_EQ(result.statistics.vertex_count, 6000);
  EXPECT_EQ(result.statistics.component_count, 1);
  EXPECT_EQ(result.statistics.boundary_loop_count, 0);
  EXPECT_EQ(result.statistics.genus, 1);
  EXPECT_EQ(result.distances.max, 0);
  EXPECT_TRUE(std::ranges::is_sorted(fractions));
  EXPECT_EQ(fractions.back(), 1);
  for (std::size_t v = 0; v < result.vertex_points.size(); ++v)
    EXPECT_EQ(result.mesh.positions[v], cloud.points[result.vertex_points[v]]);
}

TEST(AdvancingFront, SimplifiesWithinTheTolerance) {
  const PointCloud cloud{.points = test::torus_points(6000, 22)};
  const Reconstruction result = reconstruct(cloud, mesh_by_advancing_front, {.tolerance = 2e-3});
  EXPECT_LE(result.distances.max, 2e-3 * result.diagonal);
  EXPECT_LT(result.statistics.vertex_count, 2500);
  EXPECT_EQ(result.statistics.genus, 1);
  EXPECT_GT(result.statistics.face_size_counts.at(4), result.statistics.face_size_counts.at(3));
}

// Whichever way round, which CGAL leaves to addresses in memory and so to what ran before in a
// process: it is settled later, by normals or by the sign of the volume.
std::vector<Triangle> unturned(std::vector<Triangle> triangles) {
  for (Triangle& t : triangles) std::ranges::sort(t);
  std::ranges::sort(triangles);
  return triangles;
}

// CGAL says nothing of how far it is.
TEST(AdvancingFront, SaysHowFarItIsFromFirstToLast) {
  double done = 0, widest = 0;
  Callbacks callbacks;
  callbacks.progress = [&](std::string_view, double fraction) {
    EXPECT_GE(fraction, done);
    widest = std::max(widest, fraction - done);
    done = fraction;
  };
  (void)mesh_by_advancing_front(test::torus_points(50'000, 25), callbacks);
  EXPECT_EQ(done, 1);
  EXPECT_LT(widest, 0.08);
}

// A front closes the bays of a rim and half of a hole by triangles as long as the sheet.
TEST(AdvancingFront, LeavesRimAndHoleOfASheetOpen) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    std::mt19937_64 random(seed);
    const auto unit = [&] { return test::unit_number(random); };
    PointCloud cloud;
    while (cloud.points.size() < 20'000) {
      const double x = 2 * unit() - 1, y = 2 * unit() - 1;
      if (x * x + y * y > 0.16)
        cloud.points.emplace_back(x, y, 0.2 * std::sin(4 * x) * std::cos(3 * y));
    }
    for (const std::int64_t coarse_from : {1'000, 1'000'000}) {
      const Reconstruction result = reconstruct(cloud, mesh_by_advancing_front,
                                                {.tolerance = 1e-3, .coarse_from = coarse_from});
      EXPECT_EQ(result.statistics.genus, 0) << seed;
      EXPECT_EQ(result.statistics.boundary_loop_count, 2) << seed;
      EXPECT_EQ(result.strayed_count, 0) << seed;
    }
  }
}

// A power of two keeps every bit of a double, so that the triangles must be the same ones.
TEST(AdvancingFront, KnowsNoUnit) {
  const std::vector<glm::dvec3> points = test::torus_points(3000, 23);
  const std::vector<Triangle> wanted = unturned(mesh_by_advancing_front(points));
  for (const int exponent : {-900, -40, -20, -10, 40, 400}) {
    std::vector<glm::dvec3> scaled = points;
    for (glm::dvec3& p : scaled) p *= std::ldexp(1.0, exponent);
    EXPECT_EQ(unturned(mesh_by_advancing_front(scaled)), wanted) << exponent;
  }
}

TEST(AdvancingFront, MeshesAMicrometre) {
  PointCloud cloud{.points = test::torus_points(3000, 24)};
  for (glm::dvec3& p : cloud.points) p *= 1e-7;
  const Reconstruction result = reconstruct(cloud, mesh_by_advancing_front, {.tolerance = 2e-3});
  EXPECT_EQ(result.statistics.genus, 1);
  EXPECT_EQ(result.statistics.boundary_loop_count, 0);
  EXPECT_LE(result.distances.max, 2e-3 * result.diagonal);
}

TEST(AdvancingFront, RefusesWhatSpansNoSurface) {
  const auto error_of = [](const std::vector<glm::dvec3>& points) {
    return test::message_of(ErrorCode::UnusableMesh,
                            [&] { (void)mesh_by_advancing_front(points); });
  };
  EXPECT_THAT(error_of({}), HasSubstr("0 points"));
  EXPECT_THAT(error_of({{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}), HasSubstr("on a line"));
}

TEST(AdvancingFront, CanBeCancelled) {
  Callbacks callbacks;
  int calls = 0;
  callbacks.cancelled = [&] { return ++calls > 2; };
  const auto points = test::torus_points(20000, 1);
  (void)test::message_of(ErrorCode::Cancelled,
                         [&] { (void)mesh_by_advancing_front(points, callbacks); });
}

TEST(MesherProcess, AnswersAsTheFunctionDoes) {
  const auto points = test::torus_points(5000, 23);
  double last = 0;
  Callbacks callbacks;
  callbacks.progress = [&](std::string_view, double f) { last = f; };
  const std::vector<Triangle> answer = mesher_process(kProgram)(points, callbacks);
  EXPECT_EQ(unturned(answer), unturned(mesh_by_advancing_front(points)));
  EXPECT_EQ(last, 1);
}

TEST(MesherProcess, PassesErrorsOn) {
  const std::vector<glm::dvec3> line = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}};
  EXPECT_THAT(
      test::message_of(ErrorCode::UnusableMesh, [&] { (void)mesher_process(kProgram)(line, {}); }),
      HasSubstr("on a line"));
}

TEST(MesherProcess, CanBeCancelled) {
  Callbacks callbacks;
  int calls = 0;
  callbacks.cancelled = [&] { return ++calls > 3; };
  const auto points = test::torus_points(50000, 1);
  (void)test::message_of(ErrorCode::Cancelled,
                         [&] { (void)mesher_process(kProgram)(points, callbacks); });
}

TEST(MesherProcess, SaysWhenTheProgramIsNoMesher) {
  const auto points = test::torus_points(50000, 1);
  const auto error_of = [&](const char* program, ErrorCode code) {
    return test::message_of(code, [&] { (void)mesher_process(program)(points, {}); });
  };
  EXPECT_THAT(error_of("/nonexistent/program", ErrorCode::NoDevice), HasSubstr("cannot start"));
  EXPECT_THAT(error_of("/bin/true", ErrorCode::InvalidArgument),
              HasSubstr("ended with code 0 without an answer"));
  EXPECT_THAT(error_of("/bin/cat", ErrorCode::InvalidArgument),
              HasSubstr("no mesher of this version"));
}

constexpr std::size_t kPoints = 40'000;
constexpr double kTolerance = 1e-3;

// A torus with bumps, in single precision as most files are.
std::vector<glm::dvec3> bumpy_points(std::size_t count, std::uint64_t seed) {
  std::vector<glm::dvec3> points = test::torus_points(count, seed);
  for (glm::dvec3& p : points) {
    const double around = std::atan2(p.y, p.x), across = std::atan2(p.z, std::hypot(p.x, p.y) - 1);
    const glm::dvec3 middle(std::cos(around), std::sin(around), 0);
    p = middle + (1 + 0.05 * std::sin(7 * around) * std::sin(5 * across)) * (p - middle);
    p = glm::dvec3(glm::vec3(p));
  }
  return points;
}

Reconstruction coarse_first(const PointCloud& cloud, ReconstructOptions options = {}) {
  if (!options.tolerance) options.tolerance = kTolerance;
  options.coarse_from = 1000;
  return reconstruct(cloud, mesh_by_advancing_front, options);
}

double greatest_distance_to(const Reconstruction& result, std::span<const glm::dvec3> points) {
  std::vector<Triangle> triangles;
  for (std::int32_t f = 0; f < static_cast<std::int32_t>(result.mesh.face_count()); ++f) {
    const auto face = result.mesh.face(f);
    triangles.push_back({face[0], face[1], face[2]});
  }
  return measure_distances(points, result.mesh.positions, triangles).max;
}

TEST(CoarseMesh, HoldsEveryPointWithFewerVerticesThanMeshingAll) {
  const PointCloud cloud{.points = bumpy_points(kPoints, 31)};
  const Reconstruction result = coarse_first(cloud, {.pair_quads = false});
  EXPECT_GT(result.sample_count, 6'000);
  EXPECT_LT(result.sample_count, 11'000);
  EXPECT_EQ(result.strayed_count, 0);
  EXPECT_EQ(result.statistics.genus, 1);
  EXPECT_EQ(result.statistics.boundary_loop_count, 0);
  // Of all used points, by a search that knows nothing of carriers.
  std::vector<glm::dvec3> used;
  for (const std::int32_t point : result.used_points) used.push_back(cloud.points[point]);
  EXPECT_GT(used.size(), kPoints - 10);
  EXPECT_LE(result.distances.max, kTolerance * result.diagonal * (1 + 1e-9));
  EXPECT_DOUBLE_EQ(greatest_distance_to(result, used), result.distances.max);
  EXPECT_DOUBLE_EQ(
      greatest_distance_to(result, std::span(used).subspan(result.distances.farthest, 1)),
      result.distances.max);
  for (std::size_t v = 0; v < result.vertex_points.size(); ++v)
    EXPECT_EQ(result.mesh.positions[v], cloud.points[result.vertex_points[v]]);
  const Reconstruction all = reconstruct(cloud, mesh_by_advancing_front, {.tolerance = kTolerance});
  EXPECT_EQ(all.sample_count, 0);
  EXPECT_LT(result.statistics.vertex_count, 1.05 * all.statistics.vertex_count);
}

TEST(CoarseMesh, IsTheSameForEveryThreadCount) {
  const PointCloud cloud{.points = bumpy_points(30'000, 32)};
  const auto with_threads = [&](int threads) {
    oneapi::tbb::task_arena arena(threads);
    return arena.execute([&] { return coarse_first(cloud); });
  };
  const Reconstruction one = with_threads(1), four = with_threads(4);
  EXPECT_EQ(one.mesh.positions, four.mesh.positions);
  EXPECT_EQ(one.mesh.face_vertices, four.mesh.face_vertices);
  EXPECT_EQ(one.distances.rms, four.distances.rms);
}

// A box much thinner than a fifth of its points would be apart, along which a front joins both
// sides here and there.
TEST(CoarseMesh, KeepsTheSidesOfASheetApart) {
  std::mt19937_64 random(9);
  const auto unit = [&] { return test::unit_number(random); };
  constexpr double kThickness = 0.03;
  std::vector<glm::dvec3> points;
  for (int i = 0; i < 60'000; ++i) {
    const double x = 2 * unit() - 1, y = 2 * unit() - 1, side = 8.16 * unit();
    if (side < 8)
      points.emplace_back(x, y, side < 4 ? 0 : kThickness);
    else
      points.emplace_back(random() % 2 ? glm::dvec3(x, random() % 2 ? 1 : -1, kThickness * unit())
                                       : glm::dvec3(random() % 2 ? 1 : -1, x, kThickness * unit()));
  }
  const Reconstruction result = coarse_first({.points = points}, {.tolerance = 1e-3});
  EXPECT_GT(result.sample_count, 20'000);
  EXPECT_LE(result.strayed_count, 2);  // of corners that the front leaves out, as it does of all
  EXPECT_EQ(result.statistics.genus, 0);
  EXPECT_EQ(result.statistics.boundary_loop_count, 0);
  EXPECT_EQ(result.statistics.component_count, 1);
}

TEST(CoarseMesh, InsertsWherePointsObject) {
  std::mt19937_64 random(9);
  const auto unit = [&] { return test::unit_number(random); };
  std::vector<glm::dvec3> cube;
  for (int i = 0; i < 30'000; ++i) {
    glm::dvec3 p(2 * unit() - 1, 2 * unit() - 1, random() % 2 ? 1 : -1);
    const auto turns = static_cast<int>(random() % 3);
    cube.push_back(turns == 0   ? p
                   : turns == 1 ? glm::dvec3(p.y, p.z, p.x)
                                : glm::dvec3(p.z, p.x, p.y));
  }
  const Reconstruction result = coarse_first({.points = cube});
  EXPECT_LT(result.sample_count, 9'000);
  EXPECT_GT(result.inserted_count, 500);  // at edges
  EXPECT_GT(result.meshing_count, 1);
  EXPECT_EQ(result.statistics.genus, 0);
  EXPECT_EQ(result.statistics.boundary_loop_count, 0);
}

TEST(CoarseMesh, LeavesOutliersOutAndCountsThem) {
  std::vector<glm::dvec3> points = bumpy_points(kPoints, 33);
  const double spacing = 0.02;
  std::mt19937_64 random(3);
  const auto unit = [&] { return test::unit_number(random); };
  for (int i = 0; i < 300; ++i)
    points.emplace_back(3 * unit() - 1.5, 3 * unit() - 1.5, 2 + unit());  // far
  for (std::size_t i = 0; i < 100; ++i) {
    const glm::dvec3 p = points[300 * i];
    points.push_back(p + spacing * glm::normalize(glm::dvec3(p.x, p.y, 5 * p.z)));  // near
  }
  points.push_back(points[5]);
  const Reconstruction result = coarse_first({.points = points});
  EXPECT_EQ(result.duplicate_count, 1);
  EXPECT_GE(result.outlier_count, 380);
  EXPECT_LE(result.outlier_count, 410);
  EXPECT_LT(result.diagonal, 4.2);
  EXPECT_EQ(result.statistics.genus, 1);
  EXPECT_EQ(result.statistics.boundary_loop_count, 0);
}

TEST(CoarseMesh, SmoothsNoise) {
  std::vector<glm::dvec3> points = test::torus_points(30'000, 34);
  test::add_noise(points, 0.02, 5);
  ReconstructOptions options{.coarse_from = 1000};
  const PointCloud cloud{.points = points};
  const Reconstruction result = reconstruct(cloud, mesh_by_advancing_front, options);
  EXPECT_GE(result.smooth_rounds, 1);
  EXPECT_NEAR(result.noise, 0.02 / std::sqrt(12), 0.001);
  EXPECT_LT(test::rms_distance_to_torus(result.mesh.positions), 0.004);
}

TEST(CoarseMesh, SaysWhatIsNoSurface) {
  const auto error_of = [](std::vector<glm::dvec3> points) {
    return test::message_of(ErrorCode::UnusableMesh,
                            [&] { (void)coarse_first({.points = std::move(points)}); });
  };
  EXPECT_THAT(error_of(std::vector<glm::dvec3>(2000, glm::dvec3(1, 2, 3))),
              HasSubstr("1 point is left after cleaning"));
  std::vector<glm::dvec3> line;
  for (int i = 0; i < 2000; ++i) line.emplace_back(i, 2 * i, 3 * i);
  EXPECT_THAT(error_of(line), HasSubstr("span no surface"));
}

TEST(CoarseMesh, TakesAPlane) {
  std::vector<glm::dvec3> plane;
  for (int i = 0; i < 60; ++i)
    for (int j = 0; j < 60; ++j) plane.emplace_back(i, j, 0);
  const Reconstruction result = coarse_first({.points = plane});
  EXPECT_EQ(result.statistics.boundary_loop_count, 1);
  EXPECT_LT(result.statistics.vertex_count, 300);
  EXPECT_LE(result.distances.max, 1e-12);
}

// Wherever it is cancelled nothing else is told.
TEST(CoarseMesh, CanBeCancelled) {
  const PointCloud cloud{.points = bumpy_points(20'000, 35)};
  int asked = 0;
  ReconstructOptions options;
  options.callbacks.cancelled = [&] { return ++asked > 1; };
  EXPECT_THAT(test::message_of(ErrorCode::Cancelled, [&] { (void)coarse_first(cloud, options); }),
              HasSubstr("cancelled"));
}

}  // namespace
}  // namespace planish
