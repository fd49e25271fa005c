#include "planish/reconstruct/cgal/advancing_front.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "planish/reconstruct/mesher_process.h"
#include "planish/reconstruct/reconstruct.h"
#include "reconstruct/test_clouds.h"
#include "support/expect_error.h"

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

// A power of two keeps every bit of a double, so that the triangles must be the same ones.
// A front closes the bays of a rim and half of a hole by triangles as long as the sheet.
TEST(AdvancingFront, LeavesRimAndHoleOfASheetOpen) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    std::mt19937_64 random(seed);
    const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
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

}  // namespace
}  // namespace planish
