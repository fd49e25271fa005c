#include "planish/reconstruct/reconstruct.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "reconstruct/test_clouds.h"
#include "support/expect_error.h"

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
  const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
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
  const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
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

}  // namespace
}  // namespace planish
