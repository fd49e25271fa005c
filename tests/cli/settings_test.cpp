#include "options/settings.h"

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
  for (const RepairChoice choice : {RepairChoice::Safe, RepairChoice::None}) {
    EXPECT_EQ(parse_repair(name_of(choice), ""), choice);
  }
  for (const std::string text : {"use", "ignore", "auto:30", "auto:0.5"}) {
    EXPECT_EQ(name_of(parse_creases(text, "")), text);
  }
  EXPECT_EQ(name_of(parse_creases("auto", "")), "auto:30");
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
