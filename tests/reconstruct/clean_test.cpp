#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "planish/reconstruct/reconstruct.h"
#include "planish/reconstruct/reconstruct_steps.h"
#include "reconstruct/test_clouds.h"
#include "support/calls.h"

namespace planish {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(Clean, KeepsTheFirstOfPointsAtOnePlace) {
  const std::vector<glm::dvec3> points = {{1, 2, 3}, {0, 0, 0}, {1, 2, 3}, {-0.0, 0, 0}, {1, 2, 4}};
  const CleanPoints result = clean(points, {.outliers = OutlierRule::Off});
  EXPECT_THAT(result.kept, ElementsAre(0, 1, 4));
  EXPECT_EQ(result.duplicate_count, 2);
}

TEST(Clean, MeasuresTheSpacingOfARow) {
  std::vector<glm::dvec3> points;
  for (int i = 0; i < 101; ++i) points.emplace_back(0.5 * i, 0, 0);
  // Inside, three neighbours on each side: (1 + 2 + 3) * 2 / 6 steps.
  EXPECT_DOUBLE_EQ(clean(points, {.outliers = OutlierRule::Off}).spacing, 0.5 * 2);
}

TEST(Clean, RemovesStrayPointsAndNoOthers) {
  std::vector<glm::dvec3> points = test::torus_points(4000, 5);
  for (int i = 0; i < 20; ++i) points.emplace_back(0.05 * i, 0.03 * i, 1.0 + 0.1 * i);
  const CleanPoints result = clean(points);
  EXPECT_EQ(result.outlier_count, 20);
  ASSERT_EQ(result.kept.size(), 4000u);
  EXPECT_EQ(result.kept.back(), 3999);
}

TEST(Clean, RemovesWhatSticksOutOfTheSurfaceAndNothingElse) {
  std::vector<glm::dvec3> points = test::torus_points(20'000, 5);
  const CleanPoints before = clean(points);
  EXPECT_EQ(before.outlier_count + before.stray_count, 0);
  // Too near to be far from all others: a spacing off.
  for (std::size_t i = 0; i < 200; ++i) {
    const glm::dvec3 p = points[100 * i + 7];
    const double ring = std::hypot(p.x, p.y);
    const glm::dvec3 normal = glm::normalize(p - glm::dvec3(p.x / ring, p.y / ring, 0));
    points.push_back(p + before.spacing * normal);
    if (i % 20 == 0) points.push_back(points[100 * i + 8] + before.spacing * normal);
  }
  const CleanPoints result = clean(points);
  EXPECT_EQ(result.outlier_count, 0);
  EXPECT_GE(result.stray_count, 170);  // some hide each other for good
  const auto lost =
      20'000 - std::ranges::count_if(result.kept, [](std::int32_t i) { return i < 20'000; });
  EXPECT_LE(lost, 2);
  EXPECT_EQ(clean(points, {.outliers = OutlierRule::Distance}).stray_count, 0);
}

TEST(Clean, KeepsPointsOfEdges) {
  std::vector<glm::dvec3> cube;
  std::mt19937_64 random(3);
  const auto unit = [&] { return test::unit_number(random); };
  for (int i = 0; i < 12'000; ++i) {
    glm::dvec3 p(unit(), unit(), unit());
    p[i % 3] = i / 3 % 2;
    cube.push_back(p);
  }
  EXPECT_EQ(clean(cube).stray_count, 0);
}

TEST(Clean, TakesManySparsePointsForAPartOfTheShape) {
  std::vector<glm::dvec3> points;
  for (int i = 0; i < 40; ++i)
    for (int j = 0; j < 40; ++j) points.emplace_back(0.01 * i, 0.01 * j, 0);
  for (int i = 0; i < 20; ++i)
    for (int j = 0; j < 20; ++j) points.emplace_back(0.45 + 0.05 * i, 0.05 * j, 0);
  std::vector<Warning> warnings;
  CleanOptions options;
  options.callbacks.warning = [&](const Warning& w) { warnings.push_back(w); };
  EXPECT_EQ(clean(points, options).outlier_count, 0);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].code, "uneven-density");
  options.outliers = OutlierRule::Distance;
  EXPECT_GT(clean(points, options).outlier_count, 300);
}

// 3 % of the points, on half of the torus, and as many outliers all over the space.
TEST(Clean, KeepsASparsePartOfTheShapeButNoOutliers) {
  std::vector<glm::dvec3> points;
  std::mt19937_64 random(9);
  const auto unit = [&] { return test::unit_number(random); };
  for (const glm::dvec3& p : test::torus_points(60'000, 6))
    if (p.x > 0 || unit() < 0.03) points.push_back(p);
  const auto on_torus = static_cast<std::int32_t>(points.size());
  const std::int32_t sparse = static_cast<std::int32_t>(
      std::ranges::count_if(points, [](const glm::dvec3& p) { return p.x < 0; }));
  ASSERT_LT(sparse, 0.04 * on_torus);
  for (const int outliers : {0, 300}) {
    for (int i = 0; i < outliers; ++i)
      points.emplace_back(4 * unit() - 2, 4 * unit() - 2, 4 * unit() - 2);
    const CleanPoints result = clean(points);
    const std::int64_t kept = std::ranges::count_if(
        result.kept, [&](std::int32_t i) { return i < on_torus && points[i].x < 0; });
    EXPECT_GT(kept, 0.97 * sparse) << outliers;
    const std::int64_t left =
        std::ranges::count_if(result.kept, [&](std::int32_t i) { return i >= on_torus; });
    EXPECT_LE(left, 0.1 * outliers);
  }
  EXPECT_GT(clean(points, {.outliers = OutlierRule::Distance}).outlier_count, 0.9 * sparse);
}

TEST(Clean, RefusesImpossibleOptions) {
  const auto error_of = [](const CleanOptions& options) {
    return test::message_of(ErrorCode::InvalidArgument, [&] { (void)clean({}, options); });
  };
  EXPECT_THAT(error_of({.neighbour_count = 0}), HasSubstr("1 to 100"));
  EXPECT_THAT(error_of({.factor = 0}), HasSubstr("positive"));
}

TEST(Clean, CanBeCancelled) {
  CleanOptions options;
  options.callbacks.cancelled = [] { return true; };
  const auto points = test::torus_points(100, 1);
  (void)test::message_of(ErrorCode::Cancelled, [&] { (void)clean(points, options); });
}

std::vector<glm::dvec3> noisy_torus(double deviation) {
  std::vector<glm::dvec3> points = test::torus_points(8000, 11);
  std::mt19937_64 random(2);
  for (glm::dvec3& p : points) {
    const double around = std::hypot(p.x, p.y);
    const glm::dvec3 ring(p.x / around, p.y / around, 0);
    double sum = -6;  // of twelve uniform numbers: deviation 1
    for (int i = 0; i < 12; ++i) sum += test::unit_number(random);
    p += deviation * sum * glm::normalize(p - ring);
  }
  return points;
}

TEST(SmoothPoints, LeavesAQuadricWhereItIs) {
  std::vector<glm::dvec3> points;
  for (int i = 0; i < 30; ++i)
    for (int j = 0; j < 30; ++j) {
      const double x = 0.1 * i + 0.01 * (j % 3), y = 0.1 * j;
      points.emplace_back(x, y, 2 + x - y);
    }
  const auto smooth = smooth_points(points, 2);
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_LT(glm::distance(points[i], smooth[i]), 1e-12);
}

TEST(SmoothPoints, TakesNoiseAway) {
  const auto points = noisy_torus(0.01);
  EXPECT_NEAR(test::rms_distance_to_torus(points), 0.01, 5e-4);
  EXPECT_LT(test::rms_distance_to_torus(smooth_points(points, 2)), 0.006);
}

TEST(SmoothPoints, MeasuresTheNoise) {
  EXPECT_NEAR(measure_noise(noisy_torus(0.01)), 0.01, 0.0015);
  EXPECT_LT(measure_noise(noisy_torus(0)), 0.001);
}

TEST(SmoothPoints, TakesNoShapeForNoise) {
  // As coarse as that, quadratics follow neither an edge nor a narrow tube.
  EXPECT_EQ(measure_noise(test::torus_points(300, 3)), 0);
  std::vector<glm::dvec3> ridge;
  for (int i = 0; i < 40; ++i)
    for (int j = 0; j < 40; ++j) ridge.emplace_back(i, j + 0.3 * (i % 2), 3 * std::abs(j % 8 - 4));
  EXPECT_EQ(measure_noise(ridge), 0);
}

TEST(SmoothPoints, LeavesEdgesToWhoKnowsTheNoise) {
  std::mt19937_64 random(7);
  std::vector<glm::dvec3> roof;
  for (int i = 0; i < 60; ++i)
    for (int j = -30; j <= 30; ++j)
      roof.emplace_back(i + 0.1 * (j % 3), j,
                        -std::abs(j) + 0.05 * (test::unit_number(random) - 0.5));
  const auto ridge_height = [&](const std::vector<glm::dvec3>& points) {
    double sum = 0;
    for (int i = 10; i < 50; ++i) sum += points[i * 61 + 30].z;
    return sum / 40;
  };
  EXPECT_LT(ridge_height(smooth_points(roof, 2)), -0.2);
  EXPECT_GT(ridge_height(smooth_points(roof, 2, 0.0144)), -0.01);
}

TEST(SmoothPoints, TakesDegenerateClouds) {
  const std::vector<glm::dvec3> same(50, glm::dvec3(1, 2, 3));
  EXPECT_EQ(smooth_points(same, 1), same);
  EXPECT_TRUE(smooth_points({}, 3).empty());
  std::vector<glm::dvec3> line;
  for (int i = 0; i < 50; ++i) line.emplace_back(i, 0, 0);
  EXPECT_EQ(smooth_points(line, 1), line);
  EXPECT_EQ(measure_noise(line), 0);
}

}  // namespace
}  // namespace planish
