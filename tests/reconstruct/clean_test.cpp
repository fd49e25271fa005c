#include "planish/reconstruct/clean.h"

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
