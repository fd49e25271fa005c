#include "settings.h"

#include <gmock/gmock.h>

#include "planish/core/error.h"

namespace planish::command {
namespace {

TEST(Settings, EveryWordHasADefaultThatItAccepts) {
  for (const WordSetting& setting : word_settings()) {
    Settings settings;
    if (setting.initial.empty()) continue;
    EXPECT_NO_THROW(setting.set(settings, setting.initial, "here")) << setting.name;
  }
}

TEST(Settings, AnUnknownWordIsRefusedWithItsPlace) {
  for (const WordSetting& setting : word_settings()) {
    if (setting.name == "device") continue;  // names are matched with devices later
    Settings settings;
    try {
      setting.set(settings, "nonsense", "here");
      FAIL() << setting.name;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
      EXPECT_THAT(error.what(), testing::StartsWith("here: "));
    }
  }
}

TEST(Settings, NamesReadBack) {
  for (const Weights weights : {Weights::DooSabin, Weights::Averaged}) {
    EXPECT_EQ(parse_weights(name_of(weights), ""), weights);
  }
  for (const BoundaryRule rule : {BoundaryRule::Edge, BoundaryRule::EdgeAndCorner}) {
    EXPECT_EQ(parse_boundary(name_of(rule), ""), rule);
  }
  for (const bool use : {true, false}) EXPECT_EQ(parse_creases(name_of_creases(use), ""), use);
}

TEST(Settings, AutoPrecisionIsDoubleBelow1e8) {
  Settings settings;
  EXPECT_EQ(solve_precision(settings), Precision::Float);
  settings.tolerance = 1e-8;
  EXPECT_EQ(solve_precision(settings), Precision::Float);
  settings.tolerance = 0.99e-8;
  EXPECT_EQ(solve_precision(settings), Precision::Double);
  settings.precision = PrecisionChoice::Float;
  EXPECT_EQ(solve_precision(settings), Precision::Float);
}

}  // namespace
}  // namespace planish::command
