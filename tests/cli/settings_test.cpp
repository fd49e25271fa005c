#include "planish/job/job_settings.h"

#include <gmock/gmock.h>

#include "planish/core/error.h"
#include "planish/pipeline/option_table.h"
#include "planish/reconstruct/point_options.h"

namespace planish::command {
namespace {

template <class Target>
void expect_defaults(const std::vector<Option<Target>>& table, const Target& defaults) {
  for (const Option<Target>& option : table) {
    if (option.initial.empty() || option.kind == OptionKind::Switch) continue;
    Target target = defaults;
    EXPECT_NO_THROW(read_option(option, target, option.initial, "here")) << option.name;
    if (option.get) {
      EXPECT_EQ(option.get(target), option.get(defaults)) << option.name;
    }
  }
}

TEST(Settings, EveryDefaultIsWhatTheTableSays) {
  expect_defaults(option_table(), FitSettings());
  expect_defaults(point_option_table(), Settings().points);
}

// As scene files, help and schemas need it.
template <class Target>
void expect_complete(const std::vector<Option<Target>>& table) {
  for (const Option<Target>& option : table) {
    EXPECT_FALSE(option.help.empty()) << option.name;
    const bool is_shown = option.kind != OptionKind::Switch &&
                          option.kind != OptionKind::Vertices && option.kind != OptionKind::Edges;
    EXPECT_EQ(choices_of(option).empty(), !is_shown) << option.name;
    const bool has_example =
        !option.initial.empty() || !option.example.empty() || !option.words.empty();
    EXPECT_TRUE(has_example) << option.name;
    EXPECT_EQ(find_option(table, option.name), &option);
  }
}

TEST(Settings, EveryRowIsComplete) {
  expect_complete(option_table());
  expect_complete(point_option_table());
}

template <class Target>
void expect_refusals(const std::vector<Option<Target>>& table) {
  for (const Option<Target>& option : table) {
    if (option.name == "device") continue;  // names are matched with devices later
    if (option.kind == OptionKind::Switch) continue;
    Target target;
    try {
      read_option(option, target, "nonsense", "here");
      FAIL() << option.name;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
      EXPECT_THAT(error.what(), testing::StartsWith("here: ")) << option.name;
    }
  }
}

TEST(Settings, NonsenseIsRefusedWithItsPlace) {
  expect_refusals(option_table());
  expect_refusals(point_option_table());
}

// Headers of cages and reports say it so.
TEST(Settings, TextsReadBack) {
  for (const FitOption& option : option_table()) {
    if (!option.get) continue;
    std::vector<std::string> texts(option.words.begin(), option.words.end());
    if (option.name == "creases")
      texts = {"choose", "use", "ignore", "normals", "auto:30", "auto:1e-05"};
    if (option.kind == OptionKind::Number) texts = {"0.012345678901234567", "1e-07"};
    for (const std::string& text : texts) {
      FitSettings settings, again;
      read_option(option, settings, text, "");
      const std::string first = option.get(settings);
      read_option(option, again, first, "");
      EXPECT_EQ(option.get(again), first);
      if (option.kind != OptionKind::Number) {
        EXPECT_EQ(first, text);
      }
    }
  }
  FitSettings settings;
  read_option(fit_option("creases"), settings, "auto", "");
  EXPECT_EQ(option_text(settings, "creases"), "auto");
  EXPECT_EQ(option_text({}, "weld"), "");
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
